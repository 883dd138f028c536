"""FLIP between linear pictures, by its published package (flip-evaluator) [andersson20, andersson21].

Pictures are arrays [height, width, 3], linear Rec. 709. Negative values count as 0, since FLIP allows none.
"""
import dataclasses

import flip_evaluator
import numpy as np

from myrialux.report.pictures import shown


@dataclasses.dataclass(frozen=True)
class Settings:
    """What the package used, as it tells it. Exposures in stops, chosen from the reference alone."""
    pixels_per_degree: float
    start_exposure: float
    stop_exposure: float
    exposures: int
    tone_mapper: str


def hdr_flip(reference, picture, settings=None):
    """Map [height, width] of HDR-FLIP in 0 to 1, and its settings.

    Without `settings` the package chooses the exposures from the reference: all pictures of one reference get the same.
    A reference without light has no exposure: then both results are None.
    """
    reference = np.maximum(np.asarray(reference, np.float32), 0)
    picture = np.maximum(np.asarray(picture, np.float32), 0)
    if not reference.max() > 0:
        return None, None
    parameters = {} if settings is None else {
        "ppd": settings.pixels_per_degree, "startExposure": settings.start_exposure,
        "stopExposure": settings.stop_exposure, "numExposures": settings.exposures, "tonemapper": settings.tone_mapper}
    error, _, used = flip_evaluator.evaluate(reference, picture, "HDR", applyMagma=False, parameters=parameters)
    return error[:, :, 0], Settings(used["ppd"], used["startExposure"], used["stopExposure"], used["numExposures"],
                                    used["tonemapper"])


def ldr_flip(reference, picture, exposure=0.0):
    """Map [height, width] of FLIP in 0 to 1 between the pictures as shown: exposure in stops, cut to 0 to 1, sRGB."""
    error, _, _ = flip_evaluator.evaluate(shown(reference, exposure), shown(picture, exposure), "LDR", applyMagma=False)
    return error[:, :, 0]
