// What the readers of shapes, materials, textures and emitters share while a Mitsuba scene is being built.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "myrialux/scene/asset_jobs.h"
#include "myrialux/scene/mitsuba_fields.h"
#include "myrialux/scene/mitsuba_tree.h"
#include "myrialux/scene/scene.h"

namespace myrialux::mitsuba {

struct Reader {
  const Tree& tree;
  Scene& scene;
  Diagnostics& found;
  AssetJobs& assets;
  std::map<const Object*, MaterialId> materials{};
  std::map<const Object*, TextureId> textures{};
  std::map<const Object*, std::uint32_t> groups{};
  std::set<const Object*> reported_media{};
  MaterialId default_material = kNone<MaterialId>, black_material = kNone<MaterialId>;
  bool has_unsupported_emitter = false;
};

/// What a colour stands for: reflectances are bounded by 1 and seen under D65; emission is as it is.
enum class ColorUse { reflectance, factor, emission, metal_index };

Rgb to_rgb(const ColorValue& color, ColorUse use);
/// Colour, number or texture of that name.
ColorSlot read_slot(Reader& in, Fields& fields, const std::string& name, Rgb missing, ColorUse use);
/// Colour or number of that name; textures are refused.
Rgb read_color(Fields& fields, const std::string& name, Rgb missing, ColorUse use);
/// Number or texture of that name, equal in all channels.
ColorSlot read_scalar_slot(Reader& in, Fields& fields, const std::string& name, float missing, const Range& range);

TextureId read_texture(Reader& in, const Object& object);
/// The file named by the property "filename"; "" after an error.
std::string read_filename(Reader& in, Fields& fields);

MaterialId read_material(Reader& in, const Object& object);
/// Material of shapes that name none; black if they emit, as in Mitsuba.
MaterialId default_material(Reader& in, bool is_emitter);

void read_shape(Reader& in, const Object& object);
void read_emitter(Reader& in, const Object& object);
void read_area_emitter(Reader& in, const Object& object, ShapeId shape);
void read_sensor(Reader& in, const Object& object);
void read_integrator(Reader& in, const Object& object);
void read_medium(Reader& in, const Object& object);

/// Tells of a plugin type that is not in `here`: unsupported if it is in `elsewhere` (known to Mitsuba), else an error.
void report_type(Reader& in, const Object& object, std::vector<std::string> here,
                 const std::vector<std::string>& elsewhere);

}  // namespace myrialux::mitsuba
