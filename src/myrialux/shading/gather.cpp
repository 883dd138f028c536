#include "myrialux/shading/gather.h"

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

void put(Vec3 v, float* to) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }

/// The fast kernel's kind of a light, or -1.
int diffuse_kind(const VirtualLights& lights, std::size_t j) {
  switch (lights.kind[j]) {
    case LightKind::oriented:
      return static_cast<int>(DiffuseLight::oriented);
    case LightKind::point:
      return lights.extra[j] == 0xffffffffu ? static_cast<int>(DiffuseLight::point) : -1;
    case LightKind::directional:
      return static_cast<int>(DiffuseLight::directional);
    case LightKind::glossy:
      break;
  }
  return -1;
}

ColumnLight column_light(const VirtualLights& lights, const Column& column) {
  const std::size_t j = index(column.light);
  ColumnLight light{};
  put(lights.p[j], light.p), put(lights.n[j], light.n), put(lights.ng[j], light.ng);
  const Rgb rgb = column.weight * lights.light[j];
  light.rgb[0] = rgb.r, light.rgb[1] = rgb.g, light.rgb[2] = rgb.b;
  return light;
}

}  // namespace

void gather_columns(const VirtualLights& lights, std::span<const Column> columns, GatheredColumns& gathered) {
  for (DiffuseColumns& run : gathered.diffuse) run.lights.clear(), run.column.clear(), run.bumpy = false;
  gathered.others.clear();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::size_t j = index(columns[c].light);
    const int kind = diffuse_kind(lights, j);
    if (kind < 0) {
      gathered.others.push_back(static_cast<std::uint32_t>(c));
      continue;
    }
    DiffuseColumns& run = gathered.diffuse[static_cast<std::size_t>(kind)];
    run.lights.push_back(column_light(lights, columns[c]));
    run.column.push_back(static_cast<std::uint32_t>(c));
    if (lights.kind[j] == LightKind::oriented && lights.n[j] != lights.ng[j]) run.bumpy = true;
  }
}

void gather_rows(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows,
                 GatheredRows& gathered) {
  MYRIALUX_ASSERT(rows.size() <= kBlockRows);
  gathered = GatheredRows{};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::size_t i = index(rows[k]);
    const Vec3 p = receivers.p[i], n = receivers.n[i], ng = receivers.ng[i];
    for (int axis = 0; axis < 3; ++axis) {
      gathered.block.p[axis][k] = p[axis];
      gathered.block.n[axis][k] = n[axis];
      gathered.block.ng[axis][k] = ng[axis];
    }
    if (n != ng) gathered.bumpy = true;
    const BsdfParams& bsdf = receivers.bsdf[i];
    const Material& material = world.scene.materials[index(bsdf.material)];
    const std::uint64_t bit = std::uint64_t{1} << k;
    if (material.kind == BsdfKind::diffuse) {
      if (receivers.inside[i]) continue;  // the back of a one-sided surface is black
      gathered.diffuse |= bit;
      gathered.albedo[k] = bsdf.reflectance * kInvPi;
    } else {
      gathered.others |= bit;
    }
  }
}

}  // namespace myrialux
