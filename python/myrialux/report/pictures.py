"""Linear pictures as a screen shows them: tone curve and PNG data for HTML."""
import base64
import io

import numpy as np
from PIL import Image


def shown(linear, exposure=0.0):
    """Float array of the same shape in 0 to 1: exposure in stops, cut, sRGB curve (IEC 61966-2-1)."""
    x = np.clip(np.asarray(linear, np.float32) * np.float32(2.0**exposure), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055).astype(np.float32)


def png_data(linear, exposure=0.0):
    """The picture as the URL of an HTML image: data:image/png;base64,..."""
    file = io.BytesIO()
    Image.fromarray(np.rint(255 * shown(linear, exposure)).astype(np.uint8)).save(file, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode("ascii")


def luminance(linear):
    """Of linear Rec. 709, with the weights of math/vec.h."""
    return np.asarray(linear, np.float64) @ np.array([0.212671, 0.715160, 0.072169])
