// Integrates spectra against the CIE 1931 2-degree observer and the D65 illuminant [cie15].
#include "myrialux/scene/spectrum.h"

#include <algorithm>
#include <cmath>

namespace myrialux {

namespace {

constexpr double kFirst_nm = 360, kLast_nm = 830, kStep_nm = 5;
constexpr int kRows = 95;
constexpr double kYNormalization = 0.009367658735689113;    ///< Y of an equal-energy spectrum of 1 is 1
constexpr double kD65Normalization = 0.010101273599490354;  ///< Y of D65 is 1

/// x, y, z of the observer and relative power of D65, every 5 nm.
constexpr double kTable[kRows][4] = {
    {0.0001299, 3.917e-06, 0.00060610002, 46.6383},
    {0.00023210001, 6.965e-06, 0.001086, 49.3637},
    {0.00041489999, 1.239e-05, 0.001946, 52.0891},
    {0.0007416, 2.202e-05, 0.003486, 51.0323},
    {0.0013680001, 3.8999999e-05, 0.0064500012, 49.9755},
    {0.002236, 6.4e-05, 0.01054999, 52.3118},
    {0.0042429999, 0.00012, 0.02005001, 54.6482},
    {0.00765, 0.00021699999, 0.036210001, 68.7015},
    {0.01431, 0.00039599999, 0.067850009, 82.7549},
    {0.023189999, 0.00063999998, 0.1102, 87.1204},
    {0.043510001, 0.00121, 0.20739999, 91.486},
    {0.077629998, 0.0021800001, 0.37130001, 92.4589},
    {0.13438, 0.0040000002, 0.64560002, 93.4318},
    {0.21477, 0.0073000002, 1.0390501, 90.057},
    {0.28389999, 0.0116, 1.3856, 86.6823},
    {0.3285, 0.01684, 1.62296, 95.7736},
    {0.34828001, 0.023, 1.7470599, 104.865},
    {0.34806001, 0.0298, 1.7826, 110.936},
    {0.3362, 0.037999999, 1.77211, 117.008},
    {0.31869999, 0.048, 1.7441, 117.41},
    {0.29080001, 0.059999999, 1.6691999, 117.812},
    {0.2511, 0.073899999, 1.5281, 116.336},
    {0.19536, 0.090980001, 1.28764, 114.861},
    {0.14210001, 0.1126, 1.0419, 115.392},
    {0.095640004, 0.13902, 0.81295007, 115.923},
    {0.057950009, 0.1693, 0.61619997, 112.367},
    {0.03201, 0.20802, 0.46518001, 108.811},
    {0.0147, 0.2586, 0.35330001, 109.082},
    {0.0049000001, 0.32300001, 0.27200001, 109.354},
    {0.0024000001, 0.4073, 0.2123, 108.578},
    {0.0093, 0.50300002, 0.1582, 107.802},
    {0.029100001, 0.60820001, 0.1117, 106.296},
    {0.063270003, 0.70999998, 0.078249991, 104.79},
    {0.1096, 0.79320002, 0.057250012, 106.239},
    {0.1655, 0.86199999, 0.042160001, 107.689},
    {0.22574989, 0.91485012, 0.02984, 106.047},
    {0.2904, 0.954, 0.020300001, 104.405},
    {0.35969999, 0.98030001, 0.0134, 104.225},
    {0.43344989, 0.99495012, 0.0087499991, 104.046},
    {0.51205009, 1, 0.0057499991, 102.023},
    {0.59450001, 0.995, 0.0038999999, 100},
    {0.67839998, 0.97860003, 0.0027499991, 98.1671},
    {0.76209998, 0.95200002, 0.0020999999, 96.3342},
    {0.84249997, 0.91540003, 0.0018, 96.0611},
    {0.9163, 0.87, 0.001650001, 95.788},
    {0.97860003, 0.81629997, 0.0014, 92.2368},
    {1.0263, 0.75700003, 0.0011, 88.6856},
    {1.0567, 0.69489998, 0.001, 89.3459},
    {1.0622, 0.63099998, 0.00079999998, 90.0062},
    {1.0456001, 0.5668, 0.00060000003, 89.8026},
    {1.0026, 0.50300002, 0.00034, 89.5991},
    {0.93839997, 0.44119999, 0.00023999999, 88.6489},
    {0.85444993, 0.38100001, 0.00019000001, 87.6987},
    {0.75139999, 0.32100001, 9.9999997e-05, 85.4936},
    {0.64240003, 0.26499999, 4.9999991e-05, 83.2886},
    {0.54189998, 0.21699999, 2.9999999e-05, 83.4939},
    {0.4479, 0.175, 1.9999999e-05, 83.6992},
    {0.3608, 0.1382, 9.9999997e-06, 81.863},
    {0.28349999, 0.107, 0, 80.0268},
    {0.21870001, 0.081600003, 0, 80.1207},
    {0.1649, 0.061000001, 0, 80.2146},
    {0.1212, 0.044580001, 0, 81.2462},
    {0.087399997, 0.032000002, 0, 82.2778},
    {0.063600004, 0.0232, 0, 80.281},
    {0.046769999, 0.017000001, 0, 78.2842},
    {0.032900002, 0.01192, 0, 74.0027},
    {0.022700001, 0.0082099997, 0, 69.7213},
    {0.01584, 0.005723, 0, 70.6652},
    {0.01135916, 0.004102, 0, 71.6091},
    {0.0081109162, 0.002929, 0, 72.979},
    {0.0057903458, 0.0020910001, 0, 74.349},
    {0.0041094571, 0.001484, 0, 67.9765},
    {0.0028993271, 0.0010470001, 0, 61.604},
    {0.00204919, 0.00073999999, 0, 65.7448},
    {0.001439971, 0.00052, 0, 69.8856},
    {0.00099994929, 0.00036110001, 0, 72.4863},
    {0.0006900786, 0.00024920001, 0, 75.087},
    {0.00047602129, 0.0001719, 0, 69.3398},
    {0.0003323011, 0.00012, 0, 63.5927},
    {0.0002348261, 8.4799998e-05, 0, 55.0054},
    {0.00016615049, 5.9999998e-05, 0, 46.4182},
    {0.000117413, 4.2399999e-05, 0, 56.6118},
    {8.3075269e-05, 2.9999999e-05, 0, 66.8054},
    {5.8706519e-05, 2.12e-05, 0, 65.0941},
    {4.1509938e-05, 1.499e-05, 0, 63.3828},
    {2.9353259e-05, 1.06e-05, 0, 63.8434},
    {2.067383e-05, 7.4657e-06, 0, 64.304},
    {1.455977e-05, 5.2577998e-06, 0, 61.8779},
    {1.025398e-05, 3.7028999e-06, 0, 59.4519},
    {7.2214561e-06, 2.6078001e-06, 0, 55.7054},
    {5.085868e-06, 1.8365999e-06, 0, 51.959},
    {3.581652e-06, 1.2934e-06, 0, 54.6998},
    {2.5225249e-06, 9.1093e-07, 0, 57.4406},
    {1.776509e-06, 6.4152999e-07, 0, 58.8765},
    {1.251141e-06, 4.5181e-07, 0, 60.3125},
};

/// Row of the table at any wavelength inside it, by linear interpolation.
void observer(double wavelength_nm, double row[4]) {
  const double t = (wavelength_nm - kFirst_nm) / kStep_nm;
  const int i = std::clamp(static_cast<int>(t), 0, kRows - 2);
  for (int c = 0; c < 4; ++c) row[c] = kTable[i][c] + (t - i) * (kTable[i + 1][c] - kTable[i][c]);
}

/// Rgb of a spectrum given as a function, by 1000 samples at equal distances (as Mitsuba has it).
template <class Spectrum>
Rgb integrate(const Spectrum& value, bool under_d65) {
  constexpr int kSamples = 1000;
  double xyz[3] = {0, 0, 0};
  for (int i = 0; i < kSamples; ++i) {
    const double wavelength_nm = kFirst_nm + (kLast_nm - kFirst_nm) * i / (kSamples - 1);
    double row[4];
    observer(wavelength_nm, row);
    const double power = value(wavelength_nm) * (under_d65 ? row[3] * kD65Normalization : 1);
    for (int c = 0; c < 3; ++c) xyz[c] += row[c] * power;
  }
  for (double& v : xyz) v *= kYNormalization * (kLast_nm - kFirst_nm) / kSamples;
  const auto channel = [&](double x, double y, double z) {
    return static_cast<float>(std::max(0.0, x * xyz[0] + y * xyz[1] + z * xyz[2]));
  };
  return {channel(3.240479, -1.537150, -0.498535), channel(-0.969256, 1.875991, 0.041556),
          channel(0.055648, -0.204043, 1.057311)};
}

double lookup(const SpectrumSamples& samples, double wavelength_nm) {
  if (samples.empty() || wavelength_nm < samples.front().first || wavelength_nm > samples.back().first) return 0;
  const auto next = std::upper_bound(samples.begin(), samples.end(), wavelength_nm,
                                     [](double w, const auto& sample) { return w < sample.first; });
  if (next == samples.end()) return samples.back().second;
  const auto previous = next - 1;
  const double t = (wavelength_nm - previous->first) / (next->first - previous->first);
  return previous->second + t * (next->second - previous->second);
}

}  // namespace

Rgb emission_rgb(const SpectrumSamples& samples) {
  return integrate([&](double w) { return lookup(samples, w); }, false);
}

Rgb reflectance_rgb(const SpectrumSamples& samples, bool bounded) {
  const Rgb c = integrate([&](double w) { return lookup(samples, w); }, true);
  return bounded ? Rgb{std::min(c.r, 1.0f), std::min(c.g, 1.0f), std::min(c.b, 1.0f)} : c;
}

Rgb equal_energy_rgb() {  // x = y = z = 1 by definition
  return {static_cast<float>(3.240479 - 1.537150 - 0.498535), static_cast<float>(-0.969256 + 1.875991 + 0.041556),
          static_cast<float>(0.055648 - 0.204043 + 1.057311)};
}

Rgb blackbody_rgb(double temperature_k) {
  constexpr double kPlanck = 6.62607015e-34, kLight = 299792458, kBoltzmann = 1.380649e-23;
  return integrate(
      [&](double wavelength_nm) {
        const double w = wavelength_nm * 1e-9;
        const double per_metre = 2 * kPlanck * kLight * kLight / std::pow(w, 5) /
                                 std::expm1(kPlanck * kLight / (w * kBoltzmann * temperature_k));
        return per_metre * 1e-9;
      },
      false);
}

}  // namespace myrialux
