"""A robot at work without a keyboard: a systemd service that starts a launch file at boot. See docs/at-boot.md.

The command install_service writes the files of such a service, and uninstall_service removes exactly these. The service
runs ``python3 -m pioneer_control.service``, which is roslaunch with two differences: it refuses a launch file that
switches motors on by itself, and its exit code tells systemd whether starting again can help.

``unit``           the text of the unit file, from a `Service`: who runs what, where, with which ROS names. Pure
``launch_rules``   what a launch file may not do at boot, and which exit code the end of its programs gives. Pure
``installed``      writes files, keeps a list of them with their checksums, and removes them again
``launched``       checks a launch file with roslaunch's own reader, and runs it
``command_line``   the commands ``install_service`` and ``uninstall_service``: arguments, root, systemctl
"""
