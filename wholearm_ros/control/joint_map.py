"""How the joints of a hand's drives are named, signed and zeroed, against ours."""

from dataclasses import dataclass

import numpy as np

from wholearm_ros.control.setpoints import Joints


@dataclass(frozen=True, eq=False)
class JointMap:
    """Our angle = sign · theirs + offset.

    names: of their left and right joint; signs: (2,) 1 or -1; offsets: (2,) [rad], our angle where
    theirs is zero.
    """

    names: tuple[str, str]
    signs: np.ndarray
    offsets: np.ndarray

    def to_ours(self, theirs: Joints) -> Joints:
        """What their joints measure, in our convention."""
        return Joints(
            theirs.stamp,
            self.signs * theirs.angles + self.offsets,
            self.signs * theirs.velocities,
            self.signs * theirs.efforts,
        )

    def to_theirs(self, efforts: np.ndarray) -> np.ndarray:
        """(2,) [N m] of ours as their drives count them."""
        theirs: np.ndarray = self.signs * efforts
        return theirs
