// A Mitsuba XML scene as a tree of objects with typed properties; includes, defaults, aliases and references resolved.
#pragma once

#include <deque>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/math/transform.h"
#include "myrialux/math/vec.h"
#include "myrialux/scene/load.h"

namespace myrialux::mitsuba {

/// A colour as written; its meaning as reflectance or emission is chosen by the reader of the slot.
struct ColorValue {
  enum class Kind { rgb, constant, samples, blackbody };
  Kind kind = Kind::rgb;
  Rgb rgb;
  double constant = 0;                             ///< also the factor of a blackbody
  double temperature_k = 0;                        ///< blackbody
  std::vector<std::pair<double, double>> samples;  ///< wavelength in nm, value; wavelengths rise
};

/// Placements over time, one at least, as the file has them.
struct Animation {
  struct Key {
    double time = 0;
    Transform to_world;
    TextPosition at;
  };
  std::vector<Key> keys;
};

using Value = std::variant<double, std::int64_t, bool, std::string, Vec3, Transform, ColorValue, Animation>;

struct Property {
  std::string name;     ///< snake_case
  std::string spelled;  ///< as in the file
  std::string tag;
  TextPosition at;
  Value value;
  mutable bool used = false;
};

struct Object;

struct Child {
  std::string name, spelled;  ///< empty if unnamed
  std::string ref;            ///< id, if it is a reference
  TextPosition at;
  Object* object = nullptr;  ///< null only while the tree is being read, or after an error
  mutable bool used = false;
};

/// An element with a plugin type: bsdf, shape, emitter, ...
struct Object {
  std::string tag, type, spelled_type, id;
  TextPosition at;
  std::filesystem::path folder;  ///< of the file that holds it
  bool old_dialect = false;      ///< 0.5, 0.6
  std::vector<Property> properties;
  std::vector<Child> children;
};

struct Tree {
  std::deque<Object> objects;  ///< objects[0] is the scene
  std::vector<std::filesystem::path> search_paths;
  std::vector<std::string> texts;  ///< of the scene file and of the included files, in order
  const Object& scene() const { return objects.front(); }
};

/// Reads `path`; mistakes go to `found`. What could be read comes back.
Tree read_tree(const std::string& path, const LoadOptions& options, Diagnostics& found);

/// File named by `name` in an object: beside the object's file, then in <path> folders, then beside the scene.
std::filesystem::path resolve(const Tree& tree, const std::filesystem::path& folder, const std::string& name);

/// The name nearest to `name` among `allowed`: "; did you mean \"x\"?", or "" when none is near.
std::string suggestion(const std::string& name, const std::vector<std::string>& allowed);

/// "int_ior" of "intIOR", "to_world" of "toWorld".
std::string to_snake_case(const std::string& name);

}  // namespace myrialux::mitsuba
