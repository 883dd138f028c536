// Copies rows and columns into flat arrays, sorted by the kernel that will take them.
#include "myrialux/shading/gather.h"

#include <algorithm>
#include <cmath>

#include "myrialux/base/assert.h"

namespace myrialux {
namespace {

/// Lights lie anywhere in memory, and so do slices' rows in part: those so many further on are asked for.
constexpr std::size_t kAhead = 8;

void prefetch(const VirtualLights& lights, std::size_t j) {
  __builtin_prefetch(&lights.p[j]), __builtin_prefetch(&lights.n[j]), __builtin_prefetch(&lights.ng[j]);
  __builtin_prefetch(&lights.light[j]), __builtin_prefetch(&lights.kind[j]), __builtin_prefetch(&lights.extra[j]);
  if (lights.extra[j] < lights.glossy.size()) __builtin_prefetch(&lights.glossy[lights.extra[j]]);
}

void put(Vec3 v, float* to) { to[0] = v.x, to[1] = v.y, to[2] = v.z; }
void put(Rgb c, float* to) { to[0] = c.r, to[1] = c.g, to[2] = c.b; }

GeneralLight general_light(const VirtualLights& lights, const Column& column);
void add_spot(const VirtualLights::Spot& spot, GeneralLight& light, GatheredColumns& gathered);
bool add_glossy(const World& world, const VirtualLights::Glossy& glossy, GeneralLight& light, CoatTables& tables,
                GatheredColumns& gathered);
void gather_row(const World& world, const Receivers& receivers, std::size_t i, std::size_t k, CoatTables& tables,
                GatheredRows& gathered);

}  // namespace

void gather_columns(const World& world, const VirtualLights& lights, std::span<const Column> columns,
                    CoatTables& tables, GatheredColumns& gathered) {
  for (DiffuseColumns& run : gathered.diffuse) run.lights.clear(), run.column.clear(), run.bumpy = false;
  gathered.general.clear(), gathered.column.clear(), gathered.spots.clear(), gathered.lobes.clear();

  // Spots and glossy lights come first, so that blocks of diffuse rows can stop after them.
  gathered.fast.clear(), gathered.fast_column.clear();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (c + kAhead < columns.size()) prefetch(lights, index(columns[c + kAhead].light));
    const std::size_t j = index(columns[c].light);
    GeneralLight light = general_light(lights, columns[c]);
    const auto column = static_cast<std::uint32_t>(c);
    if (light.shape == LightShape::spot || light.shape == LightShape::glossy) {
      if (light.shape == LightShape::spot)
        add_spot(lights.spots[lights.extra[j]], light, gathered);
      else if (!add_glossy(world, lights.glossy[lights.extra[j]], light, tables, gathered))
        continue;
      gathered.general.push_back(light), gathered.column.push_back(column);
      continue;
    }
    gathered.fast.push_back(light), gathered.fast_column.push_back(column);
    DiffuseColumns& run = gathered.diffuse[static_cast<std::size_t>(light.shape)];
    run.lights.push_back(light.at), run.column.push_back(column);
    if (light.shape == LightShape::oriented && lights.n[j] != lights.ng[j]) run.bumpy = true;
  }
  gathered.n_slow = gathered.general.size();
  gathered.general.insert(gathered.general.end(), gathered.fast.begin(), gathered.fast.end());
  gathered.column.insert(gathered.column.end(), gathered.fast_column.begin(), gathered.fast_column.end());
}

void gather_rows(const World& world, const Receivers& receivers, std::span<const ReceiverId> rows, CoatTables& tables,
                 GatheredRows& gathered) {
  MYRIALUX_ASSERT(rows.size() <= kBlockRows);
  gathered.diffuse = gathered.others = 0;
  gathered.lobes.rows.fill(0);
  std::fill_n(gathered.lobes.field[kFieldTable], kBlockRows, 0.0f);  // looked up whatever the row
  gathered.albedo.fill({});
  gathered.bumpy = false;
  for (std::size_t k = 0; k < rows.size(); ++k) gather_row(world, receivers, index(rows[k]), k, tables, gathered);
  // Rows that do not exist copy the last one: their numbers are finite, and no bit ever names them.
  for (std::size_t k = rows.size(); k < kBlockRows; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      RowBlock& b = gathered.block;
      b.p[axis][k] = b.p[axis][rows.size() - 1];
      b.n[axis][k] = b.n[axis][rows.size() - 1];
      b.ng[axis][k] = b.ng[axis][rows.size() - 1];
    }
}

namespace {

GeneralLight general_light(const VirtualLights& lights, const Column& column) {
  const std::size_t j = index(column.light);
  GeneralLight light;
  put(lights.p[j], light.at.p), put(lights.n[j], light.at.n), put(lights.ng[j], light.at.ng);
  put(column.weight * lights.light[j], light.at.rgb);
  switch (lights.kind[j]) {
    case LightKind::oriented:
      light.shape = LightShape::oriented;
      break;
    case LightKind::glossy:
      light.shape = LightShape::glossy;
      break;
    case LightKind::point:
      light.shape = lights.extra[j] == 0xffffffffu ? LightShape::point : LightShape::spot;
      break;
    case LightKind::directional:
      light.shape = LightShape::directional;
      break;
  }
  return light;
}

void add_spot(const VirtualLights::Spot& spot, GeneralLight& light, GatheredColumns& gathered) {
  const float cutoff = std::acos(spot.cos_cutoff), width = cutoff - std::acos(spot.cos_beam);
  light.extra = static_cast<std::uint32_t>(gathered.spots.size());
  gathered.spots.push_back({spot.cos_cutoff, spot.cos_beam, cutoff, width > 0 ? 1 / width : 0});
}

/// False if the light sends nothing.
bool add_glossy(const World& world, const VirtualLights::Glossy& glossy, GeneralLight& light, CoatTables& tables,
                GatheredColumns& gathered) {
  const Material& material = world.scene.materials[index(glossy.bsdf.material)];
  const Vec3 n{light.at.n[0], light.at.n[1], light.at.n[2]};
  const FixedLobes fixed =
      fix_lobes(make_bsdf(material, glossy.bsdf, world.sharp_alpha), n, glossy.wi, FixedEnd::source, tables);
  if (!fixed.any) return false;
  if (fixed.mirrored)
    for (float& x : light.at.ng) x = -x;
  light.extra = static_cast<std::uint32_t>(gathered.lobes.size());
  gathered.lobes.push_back(fixed.lobes);
  auto& field = gathered.lobes.back().field;
  for (std::size_t k = 0; k < 3; ++k) {
    for (const LobeField f : {kFieldBase, kFieldGloss, kFieldPass}) field[f + k] *= light.at.rgb[k];
    for (const LobeField f : {kFieldN, kFieldO}) field[f + k] = -field[f + k];
  }
  return true;
}

Rgb diffuse_base(const LightLobes& lobes) {
  const float* base = lobes.field.data() + kFieldBase;
  return {base[0], base[1], base[2]};
}

/// All that the row's kind looks at.
void put_fields(const LightLobes& lobes, std::size_t k, RowLobes& rows) {
  if (lobes.lobe_class.kind == LobeKind::diffuse) {
    for (const LobeField first : {kFieldN, kFieldBase})
      for (std::size_t f = first; f < first + 3u; ++f) rows.field[f][k] = lobes.field[f];
    return;
  }
  for (std::size_t f = 0; f < kLobeFields; ++f) rows.field[f][k] = lobes.field[f];
}

void gather_row(const World& world, const Receivers& receivers, std::size_t i, std::size_t k, CoatTables& tables,
                GatheredRows& gathered) {
  const BsdfParams& params = receivers.bsdf[i];
  const Vec3 p = receivers.p[i], n = receivers.n[i];
  Vec3 ng = receivers.ng[i];
  // The receiver's normals face wo; a BSDF seen from inside stands the other way round, and is mirrored back.
  const Vec3 bsdf_n = receivers.inside[i] ? -n : n;
  const FixedLobes fixed =
      fix_lobes(make_bsdf(world.scene.materials[index(params.material)], params, world.sharp_alpha), bsdf_n,
                receivers.wo[i], FixedEnd::viewer, tables);
  if ((receivers.inside[i] != 0) != fixed.mirrored) ng = -ng;
  if (n != ng) gathered.bumpy = true;
  for (int axis = 0; axis < 3; ++axis) {
    gathered.block.p[axis][k] = p[axis];
    gathered.block.n[axis][k] = n[axis];
    gathered.block.ng[axis][k] = ng[axis];
  }
  if (!fixed.any) return;
  put_fields(fixed.lobes, k, gathered.lobes);
  const std::uint64_t bit = std::uint64_t{1} << k;
  gathered.lobes.rows[lobe_class_index(fixed.lobes.lobe_class)] |= bit;
  if (fixed.lobes.lobe_class.kind == LobeKind::diffuse) {
    gathered.diffuse |= bit;
    gathered.albedo[k] = diffuse_base(fixed.lobes);
  } else {
    gathered.others |= bit;
  }
}

}  // namespace
}  // namespace myrialux
