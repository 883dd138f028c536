// Spectra as linear Rec. 709 colours, as Mitsuba's RGB mode converts them.
#pragma once

#include <utility>
#include <vector>

#include "myrialux/math/vec.h"

namespace myrialux {

using SpectrumSamples = std::vector<std::pair<double, double>>;  ///< wavelength in nm (rising), value; 0 outside

/// Emission: integral against the CIE 1931 colour matching functions. Negative channels become 0.
Rgb emission_rgb(const SpectrumSamples& samples);
/// Reflectance, or index of refraction: seen under D65. Channels stay in [0, 1] if `bounded`, else above 0.
Rgb reflectance_rgb(const SpectrumSamples& samples, bool bounded);
/// Emission of 1 at all wavelengths.
Rgb equal_energy_rgb();
/// Planck's law, W m^-2 sr^-1 nm^-1.
Rgb blackbody_rgb(double temperature_k);

}  // namespace myrialux
