"""``python3 -m pioneer_control.service [PACKAGE] FILE [NAME:=VALUE ...]``: what the unit file of a service starts."""

import pioneer_control.interrupt  # noqa: F401  # from here on Ctrl-C is no error
from pioneer_control.service.launched import main

raise SystemExit(main())
