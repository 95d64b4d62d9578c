#!/usr/bin/python3
"""Writes when map -> odom came and who sent it into a file: seconds by a clock that never jumps, seconds of its stamp, name of the
publisher. Waits for the master, and outlives it."""

import sys
import time

import rospy
from tf2_msgs.msg import TFMessage

MAP, ODOM = "map", "odom"


def main():
    with open(sys.argv[1], "w") as file:
        def write(message):
            now_s, publisher = time.monotonic(), message._connection_header["callerid"]
            for transform in message.transforms:
                if (transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/")) == (MAP, ODOM):
                    print(now_s, transform.header.stamp.to_sec(), publisher, file=file, flush=True)

        rospy.init_node("map_odom_log", disable_signals=True)
        rospy.Subscriber("/tf", TFMessage, write, queue_size=1000)
        rospy.spin()


def read(path):
    """Figures of a file that was written so. The first transform comes with the first pose."""
    rows = [line.split() for line in open(path)]
    arrivals, stamps = ([float(row[i]) for row in rows] for i in (0, 1))
    return {
        "map_odom_publishers": len({row[2] for row in rows}),
        "map_odom_transforms": len(rows),
        "map_odom_largest_gap_s": max((b - a for a, b in zip(arrivals, arrivals[1:])), default=None),
        "map_odom_largest_gap_of_stamps_s": max((b - a for a, b in zip(stamps, stamps[1:])), default=None),
    }


if __name__ == "__main__":
    main()
