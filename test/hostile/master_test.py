#!/usr/bin/python3
"""The ROS master comes later than the nodes, or goes before them: they wait for it, go on without it, and
end by themselves at Ctrl-C."""
import os
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/lib"))
from hostile_suite import NODES, Suite, wait_for  # noqa: E402

BUILD = Path(os.environ["HYMM_BUILD_DIR"])
BAG = ROOT / "bags/car_park.bag"
PATIENCE_S = 120.0  # only what is broken needs it
# Without its parameter `output`, which only a master can hold, the recorder refuses to start.
WAITING = [name for name in NODES if name != "recorder"]


class MasterTest(unittest.TestCase):
    """In one process only one master is known to rospy: the first test is the one that needs it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def suite(self, **arguments):
        suite = Suite(BUILD, self.work, **arguments)
        self.addCleanup(suite.end)
        return suite

    def expect_clean_ends(self, suite):
        for name in list(suite.running):
            suite.interrupt(name)
        self.assertEqual(suite.crashes, [])

    def test_1_nodes_go_on_without_the_master_and_end_by_themselves(self):
        suite = self.suite()
        suite.configure(ROOT / "config/datasets/car_park.yaml", use_sim_time="true",
                        recorder__output=self.work / "recorded")
        suite.start()
        import rospy
        rospy.init_node("master_test", disable_signals=True)
        from suite_watcher import Watcher
        watcher = Watcher()
        suite.play(BAG, "-l")
        self.assertEqual(watcher.idle(PATIENCE_S), [])
        suite.stop_master()
        self.assertEqual(watcher.idle(PATIENCE_S), [], "without a master")
        self.expect_clean_ends(suite)

    def test_2_nodes_wait_for_the_master_and_tell_so(self):
        import rosgraph
        suite = self.suite(with_master=False)
        suite.start(*WAITING)

        def waits(name):
            return "Failed to contact master" in (self.work / f"{name}.log").read_text()

        self.assertTrue(wait_for(lambda: all(waits(name) for name in WAITING), PATIENCE_S),
                        [name for name in WAITING if not waits(name)])
        self.assertEqual(suite.note_crashes(), [])
        suite.start_master()
        master = rosgraph.Master("/master_test")

        def missing():
            """A node offers this service once it has started."""
            services = {service for service, _ in master.getSystemState()[2]}
            return [name for name in WAITING if f"/{name}/set_logger_level" not in services]

        self.assertTrue(wait_for(lambda: not missing(), PATIENCE_S), missing())
        self.expect_clean_ends(suite)


if __name__ == "__main__":
    unittest.main(verbosity=1, warnings="ignore")  # of sockets that rospy leaves open
