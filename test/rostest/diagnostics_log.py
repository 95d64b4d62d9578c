#!/usr/bin/python3
"""Writes what comes on /diagnostics into a file, each status as a line of JSON, at once: whoever ends it loses nothing.
Waits for the master, and outlives it."""
import json
import sys

import rospy
from diagnostic_msgs.msg import DiagnosticArray


def main():
    with open(sys.argv[1], "w") as file:
        def write(message):
            for status in message.status:
                values = {value.key: value.value for value in status.values}
                print(json.dumps([status.name, values]), file=file, flush=True)

        rospy.init_node("diagnostics_log", disable_signals=True)
        rospy.Subscriber("/diagnostics", DiagnosticArray, write, queue_size=1000)
        rospy.spin()


if __name__ == "__main__":
    main()
