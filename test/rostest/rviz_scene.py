"""A made-up map on the topics of the suite: landmarks on a lattice, LTRs between them, layers."""
import math

import rospy
from hymm.msg import (Landmark, LandmarkMap, LandmarkObservation, LandmarkUpdate, Ltr, LtrGrid,
                      LtrMap)

OCCUPIED, FREE = 5.0, -5.0  # log-odds


def landmark(number, x, y, kind=LandmarkObservation.TYPE_TRUNK, covariance=(0.01, 0, 0, 0.01),
             diameter=1.0):
    told = Landmark(id=number, type=kind, diameter=diameter, diameter_variance=0.01,
                    observations=10)
    told.position.x, told.position.y = x, y
    told.covariance = list(covariance)
    return told


def triangle_cells(alpha_cells, beta_cells, value):
    """The cells of a layer, `value(alpha, beta)` at the middle of each."""
    cells = []
    for j in range(beta_cells):
        row = math.ceil(alpha_cells * (beta_cells - j) / beta_cells)
        cells += [value((i + 0.5) / alpha_cells, (j + 0.5) / beta_cells) for i in range(row)]
    return cells


class Scene:
    """`side` x `side` landmarks, `step` metres apart, and two LTRs in each square between them."""

    def __init__(self, side, step, cells):
        self.side, self.step, self.cells = side, step, cells
        self.landmarks = [landmark(1 + row * side + column, step * column, step * row)
                          for row in range(side) for column in range(side)]
        self.ltrs = []
        for row in range(side - 1):
            for column in range(side - 1):
                corner = 1 + row * side + column
                for ids in ((corner, corner + 1, corner + side),
                            (corner + side + 1, corner + side, corner + 1)):
                    self.ltrs.append(Ltr(id=len(self.ltrs), landmark_ids=ids,
                                         neighbours=[-1, -1, -1], alpha_cells=cells,
                                         beta_cells=cells, shape_factor=1.0))
        self.version = 0
        self._map = rospy.Publisher("landmarks", LandmarkMap, queue_size=2, latch=True)
        self._updates = rospy.Publisher("landmark_updates", LandmarkUpdate, queue_size=10)
        self._ltrs = rospy.Publisher("ltrs", LtrMap, queue_size=2, latch=True)
        self.grids = rospy.Publisher("ltr_grids", LtrGrid, queue_size=10000)

    def is_heard(self):
        """Whether somebody listens to all that is sent but once."""
        return all(p.get_num_connections() > 0 for p in (self.grids, self._updates))

    def publish_map(self):
        self.version += 1
        message = LandmarkMap(version=self.version, landmarks=self.landmarks, block_range=30.0)
        message.header.frame_id = "map"
        message.header.stamp = rospy.Time.now()
        self._map.publish(message)

    def publish_ltrs(self):
        message = LtrMap(landmark_version=self.version, ltrs=self.ltrs)
        message.header.frame_id = "map"
        self._ltrs.publish(message)

    def publish_update(self, changed):
        """These landmarks as they are now."""
        message = LandmarkUpdate(since_version=self.version, version=self.version + 1,
                                 changed=changed)
        message.header.frame_id = "map"
        message.header.stamp = rospy.Time.now()
        self.version += 1
        self._updates.publish(message)

    def publish_occupancy(self, ltr, value):
        self.grids.publish(LtrGrid(ltr=ltr, layer="occupancy", model="occupancy",
                                   alpha_cells=self.cells, beta_cells=self.cells, channels=1,
                                   cells=triangle_cells(self.cells, self.cells, value)))
