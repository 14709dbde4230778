"""The page in a browser. ``page/`` has its files; ``one_file`` joins them with a recording into one HTML file."""
