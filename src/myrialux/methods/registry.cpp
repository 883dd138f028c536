// The list of methods that --method knows.
#include "myrialux/base/error.h"
#include "myrialux/methods/render.h"

namespace myrialux {

const std::vector<MethodInfo>& all_methods() {
  static const std::vector<MethodInfo> methods = {
      {"bamc", "slices, slice lightcut, boolean adaptive matrix completion", "Wang and Holzschuch 2020, section 4",
       render_bamc},
      {"amc", "the same slices and cuts, adaptive matrix completion by pseudo-inverse",
       "Krishnamurthy and Singh 2014; Wang and Holzschuch 2020, section 3.2", render_amc},
      {"gauss-jordan", "the same slices and cuts, adaptive matrix completion by elimination over GF(2)",
       "Wang and Holzschuch 2020, section 5.6", render_gauss_jordan},
      {"matrix-separation",
       "the same slices and cuts, visibility guessed, validated and split into low rank and sparse", "Huo et al. 2015",
       render_matrix_separation},
      {"slice-lightcuts", "the same slices and cuts, every shadow ray traced",
       "Wang and Holzschuch 2020, section 5.3.4", render_slice_lightcuts},
      {"lightcuts", "a cut of the light tree for every receiver, refined to a share of its total", "Walter et al. 2005",
       render_lightcuts, "lightcuts.error"},
      {"lightslice", "slices, columns clustered by a reduced matrix of one traced row a slice, every shadow ray traced",
       "Ou and Pellacini 2011", render_lightslice},
      {"mdlc", "one cut a pixel through the product of its receivers and the lights, 2 % threshold",
       "Walter et al. 2006", render_mdlc, "mdlc.error"},
      {"brute-force", "every receiver, every virtual light, every ray", "-", render_brute_force, ""},
      {"path", "path tracer with next-event estimation and multiple importance sampling", "-", {}, ""},
  };
  return methods;
}

const MethodInfo& find_method(const std::string& name) {
  std::string names;
  for (const MethodInfo& m : all_methods()) {
    if (m.name == name) return m;
    names += (names.empty() ? "" : ", ") + m.name;
  }
  throw Error(ErrorKind::usage, "unknown method '" + name + "'; known: " + names);
}

}  // namespace myrialux
