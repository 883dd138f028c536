// Typed access to the properties and children of one object; what nobody asked for is told at the end.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "myrialux/base/error.h"
#include "myrialux/math/transform.h"
#include "myrialux/scene/mitsuba_tree.h"

namespace myrialux::mitsuba {

/// Numbers that a property may have.
struct Range {
  double lower = -1e30, upper = 1e30;
  bool lower_open = false;  ///< lower itself is refused
  std::string told{};       ///< "greater than 0"; made from the bounds if empty
};

class Fields {
 public:
  Fields(const Object& object, Diagnostics& found) : object_(object), found_(found) {}

  const Object& object() const { return object_; }
  /// Property or child of that name, marked as used; null if absent.
  const Property* property(const std::string& name);
  const Child* child(const std::string& name);
  bool has(const std::string& name);

  double number(const std::string& name, double missing, const Range& range = {});
  std::int64_t integer(const std::string& name, std::int64_t missing, std::int64_t lower, std::int64_t upper);
  bool boolean(const std::string& name, bool missing);
  std::string text(const std::string& name, const std::string& missing);
  /// Text that must be one of `allowed`.
  std::string choice(const std::string& name, const std::string& missing, const std::vector<std::string>& allowed);
  Vec3 vector(const std::string& name, Vec3 missing);
  Transform transform(const std::string& name);
  /// Properties that change nothing in a picture of ours.
  void ignore(const std::vector<std::string>& names);

  TextPosition at(const std::string& name) const;
  void error(const std::string& name, const std::string& what) { found_.error(at(name), what); }
  void wrong_type(const Property& property, const std::string& allowed);
  /// Warns of every property and named child that was not asked for.
  void finish();
  Diagnostics& found() { return found_; }

 private:
  const Object& object_;
  Diagnostics& found_;
  std::vector<std::string> asked_;
};

/// Marks everything in an object, and in what it holds, as used: nothing is known about its parameters.
void accept_all(const Object& object);

}  // namespace myrialux::mitsuba
