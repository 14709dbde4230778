"""The Pioneer Arm: five joints and a gripper on a robot, over the robot's line. No ROS, no I/O, no clock.

Open ``session`` first. It is one arm, as the client's ``LineDevices`` wants it: packets and time go in, packets go out.

``kinematics``  from joint angles to where the gripper is, and back
``joints``      the names of the joints, and what the arm reports of them: ticks to radians, limits, speeds
``status``      what one status packet means, in either of its two layouts
``motion``      checks a motion through several positions, and turns it into ticks and speeds
``orders``      what the arm is told, each as an object with its own steps: power on, go home, park, ...
``timers``      what moves the arm by itself, and when the user is told
``phases``      the phases of a session: no link, asking, no arm, or an arm and its orders
``findings``    what there is to tell of an arm: its condition, and its diagnostics
``session``     finds the arm, and says what it obeys when

Facts are from the arm sheet (part 2 of the sheet of camera and arm, sections 12 to 20). The arm measures nothing: all
positions are those to which its server has stepped the servos.
"""
