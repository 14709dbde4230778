"""The page in a browser: robots live, driven by hand. ``python3 -m pioneer_control.web`` shows a simulated robot.

Two processes. The **owner** has the robots and decides who may tell them what. The **server** is its child: it passes
pictures to browsers, and orders back. It may die or hang at any time: the robots stop, and another one begins.

::

    robot == client.Robot == client_robot == owner == exchange == server == WebSocket == page/
                                    seats __/             fleet __/

====================  ==================================================================================
``__main__``          the program: starts a simulated robot if none is named, prints the address
``owner``             the process that owns robots: its loop, and the server as its child
``seats``             who may tell which robot what
``site``              where the page is served: sockets, keys, what to print
``client_crew``       the robots whose ports were named
``client_robot``      one robot of the client library: its frames, status and controls
``backend``           what lies between the page and robots of any kind
``exchange``          the messages between owner and server
``server``            HTTP and WebSocket, with tornado
``guard``             who may talk to the server, and which files it has
``fleet``             what each viewer gets, and when
``orders``            the messages of the page, checked
``frames``            what changes ten times a second of a robot, as bytes
``columns``           the same of a whole recording
``trail``             the way that a robot went lately
``truth``             what the simulator tells of its world and tasks, and the orders to it
``from_messages``     the messages of a robot's topics, as the page shows them
``navigation_picture``  what navigation tells of a robot, as the page shows it
``graph``             the robots of a ROS graph
``graph_navigation``  what persons tell their navigation
``node``              the ROS node that serves them
``recorded``          a bag as a recording for the page
``one_file``          joins the page and a recording into one HTML file
``programs``          the programs that share robots with persons: who gets which robot
``program_line``      the robot's side of the line to a program that shares its robot with persons
``classroom``         who is who in a class: which student has which robot
``class_desk``        the rules of a class: what students and teachers may do, and what they are told
``simulator_orders``  the teacher's orders in the simulator's words
``task_board``        the ranking of a task, with students' names
``paced_feed``        keeps long texts that change all the time within the page's budget
``qr``                an address as a QR code
``wheels``            what a laptop needs for programs, for pip
``tied``              runs a program as a child that ends with its parent
====================  ==================================================================================

``docs/page-protocol.md`` says what page and server say to each other.
"""
