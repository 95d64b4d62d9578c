#!/usr/bin/python3
"""Small files of each kind for the fuzzers to begin with: make_fuzz_seeds.py FOLDER."""
import sys
import zipfile
from pathlib import Path

import numpy
import rosbag
import rospy
import scipy.io
from geometry_msgs.msg import TransformStamped
from hymm.msg import DeadReckoning
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage


def write(bag, topic, message, time_s):
    """Without the text of the message's definition, which nobody reads: a fuzzer would spoil little
    else."""
    bag.write(topic, message, rospy.Time(time_s), connection_header={
        "topic": topic, "type": message._type, "md5sum": message._md5sum, "message_definition": ""})


def transform():
    fixed = TransformStamped(child_frame_id="laser")
    fixed.header.frame_id = "base_link"
    fixed.transform.rotation.w = 1.0
    return TFMessage([fixed])


def main(folder):
    for name in ("mat_file", "zip_file", "bag", "saved_map", "saved_state"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    content = {"LASER": numpy.arange(12.0).reshape(3, 4), "TLsr": numpy.array([[1, 2, 3]], "uint32")}
    scipy.io.savemat(folder / "mat_file/plain.mat", content)
    scipy.io.savemat(folder / "mat_file/packed.mat", content, do_compression=True)
    scipy.io.savemat(folder / "mat_file/old.mat", {"LASER": content["LASER"]}, format="4")
    for name, kind in (("stored", zipfile.ZIP_STORED), ("deflated", zipfile.ZIP_DEFLATED)):
        with zipfile.ZipFile(folder / f"zip_file/{name}.zip", "w", kind) as archive:
            archive.writestr("folder/LASER.txt", "1 2 3\n" * 20)
    for name in ("none", "bz2", "lz4"):
        with rosbag.Bag(str(folder / f"bag/{name}.bag"), "w", compression=name) as bag:
            write(bag, "/tf_static", transform(), 1)
            for i in (1, 2):
                write(bag, "scan", LaserScan(ranges=[1.0] * 9), i)
                write(bag, "dead_reckoning", DeadReckoning(speed=1.0), i)


main(Path(sys.argv[1]))
