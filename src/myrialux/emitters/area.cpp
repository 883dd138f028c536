// Samples emitting surfaces uniformly by area, spheres from outside by solid angle.
#include "myrialux/emitters/area.h"

#include <cmath>

#include "myrialux/math/warp.h"

namespace myrialux {

namespace {

constexpr double kTwoPi = 6.283185307179586;
/// Points at which a textured emitter is looked up to estimate its power.
constexpr std::size_t kPowerPoints = 16384;

double norm(const Point3d& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
Point3d cross(const Point3d& a, const Point3d& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Point3d column(const Transform& m, int c) { return {m.rows()[c], m.rows()[4 + c], m.rows()[8 + c]}; }
Point3d widen(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 narrow(const Point3d& p) { return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}; }
std::vector<float> triangle_areas(const Mesh& mesh);
/// Area of the cylinder's band at angle phi, per turn and unit height: constant unless the cylinder is sheared.
double cylinder_density(const Transform& to_world, double phi);
/// Points of an additive recurrence that fill the unit square evenly. Source: [roberts18]
Vec2 even_point(std::size_t i);

}  // namespace

AreaSampler::AreaSampler(const Scene& scene, const AreaEmitter& emitter)
    : scene_(scene), shape_(scene.shapes[index(emitter.shape)]), radiance_(emitter.radiance) {
  if (const MeshId* mesh = std::get_if<MeshId>(&shape_.geometry)) {
    mesh_ = &scene.meshes[index(*mesh)];
    triangle_pick_ = Distribution1D(triangle_areas(*mesh_));
    area_ = triangle_pick_.sum();
  } else {
    quadric_ = &std::get<Quadric>(shape_.geometry);
    from_world_ = quadric_->to_world.inverse();
    const Transform& m = quadric_->to_world;
    if (quadric_->kind == Quadric::Kind::sphere) {
      is_sphere_ = true;
      emits_inwards_ = shape_.flip_normals != (m.determinant3() < 0);
      centre_ = {m.rows()[3], m.rows()[7], m.rows()[11]};
      radius_ = norm(column(m, 0));
      area_ = 2 * kTwoPi * radius_ * radius_;
    } else if (quadric_->kind == Quadric::Kind::disk) {
      area_ = kTwoPi / 2 * norm(cross(column(m, 0), column(m, 1)));
    } else {
      constexpr int kSteps = 1024;
      for (int k = 0; k < kSteps; ++k) area_ += cylinder_density(m, kTwoPi * k / kSteps) / kSteps;
    }
  }
  power_ = area_ > 0 ? mean_radiance() * static_cast<float>(area_ * kTwoPi / 2) : Rgb{};
}

AreaSampler::Sample AreaSampler::sample(float u_pick, Vec2 u) const {
  if (!(area_ > 0)) return {};
  if (mesh_) {
    const Distribution1D::Sample triangle = triangle_pick_.sample(u_pick);
    const Vec2 b = sample_triangle(u);
    return {point_on_triangle(*mesh_, shape_.flip_normals, static_cast<std::uint32_t>(triangle.index), b.x, b.y),
            static_cast<float>(1 / area_)};
  }
  const Point3d o = object_point(u);
  const double density =
      quadric_->kind == Quadric::Kind::cylinder ? cylinder_density(quadric_->to_world, std::atan2(o[1], o[0])) : area_;
  return {point_on_quadric(*quadric_, shape_.flip_normals, o), static_cast<float>(1 / density)};
}

float AreaSampler::pdf_area(Vec3 p_on) const {
  if (!(area_ > 0)) return 0;
  if (!quadric_ || quadric_->kind != Quadric::Kind::cylinder) return static_cast<float>(1 / area_);
  const Point3d o = transform_point(from_world_, widen(p_on));
  return static_cast<float>(1 / cylinder_density(quadric_->to_world, std::atan2(o[1], o[0])));
}

AreaSampler::Towards AreaSampler::sample_towards(Vec3 p, float u_pick, Vec2 u) const {
  Towards s;
  const Cone cone = is_sphere_ ? cone_from(p) : Cone{};
  if (cone.versine > 0) {
    if (emits_inwards_) return s;  // the lit inner side is hidden by the near half
    const Vec3 w = Frame(cone.axis).to_world(sample_narrow_cone(u, cone.versine));
    const double along = double(dot(w, cone.axis)) * cone.distance;
    const Vec3 side = w - cone.axis * dot(w, cone.axis);
    const double away2 = cone.distance * cone.distance * double(length_squared(side));
    const double t = along - std::sqrt(std::max(0.0, radius_ * radius_ - away2));
    Point3d o = transform_point(from_world_, {p.x + t * w.x, p.y + t * w.y, p.z + t * w.z});
    const double scale = 1 / norm(o);
    s.at = point_on_quadric(*quadric_, shape_.flip_normals, {o[0] * scale, o[1] * scale, o[2] * scale});
    s.pdf_omega = 1 / (2 * kPi * cone.versine);
  } else {
    const Sample on = sample(u_pick, u);
    if (on.pdf_area == 0) return s;
    s.at = on.at;
    s.pdf_omega = pdf_omega(p, on.at.p, on.at.ng);
  }
  const Vec3 d = s.at.p - p;
  s.distance = length(d);
  if (!(s.distance > 0) || dot(d, s.at.ng) >= 0) return {};
  s.wi = d / s.distance;
  return s;
}

float AreaSampler::pdf_omega(Vec3 p, Vec3 p_on, Vec3 ng) const {
  if (is_sphere_) {
    const Cone cone = cone_from(p);
    if (cone.versine > 0) return emits_inwards_ ? 0 : 1 / (2 * kPi * cone.versine);
  }
  const Vec3 d = p - p_on;
  const float distance2 = length_squared(d), cosine = dot(d, ng) / std::sqrt(distance2);
  return cosine > 0 ? pdf_area(p_on) * distance2 / cosine : 0;
}

AreaSampler::Cone AreaSampler::cone_from(Vec3 p) const {
  const Point3d to{centre_[0] - p.x, centre_[1] - p.y, centre_[2] - p.z};
  Cone cone;
  cone.distance = norm(to);
  if (cone.distance <= radius_ * (1 + 1e-5)) return cone;  // at the surface the cone is the half space: use the area
  const double sine2 = radius_ * radius_ / (cone.distance * cone.distance);
  cone.versine = static_cast<float>(sine2 / (1 + std::sqrt(1 - sine2)));
  cone.axis = narrow({to[0] / cone.distance, to[1] / cone.distance, to[2] / cone.distance});
  return cone;
}

Point3d AreaSampler::object_point(Vec2 u) const {
  if (quadric_->kind == Quadric::Kind::sphere) {
    const double z = 1 - 2 * double(u.x), r = std::sqrt(std::max(0.0, 1 - z * z)), phi = kTwoPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  if (quadric_->kind == Quadric::Kind::disk) {
    const Vec2 d = sample_disc(u);
    return {d.x, d.y, 0};
  }
  return {std::cos(kTwoPi * u.x), std::sin(kTwoPi * u.x), u.y};
}

Rgb AreaSampler::radiance(Vec2 uv) const {
  if (radiance_.texture == kNone<TextureId>) return radiance_.value;
  return radiance_.value * evaluate(scene_.textures[index(radiance_.texture)], uv);
}

Rgb AreaSampler::mean_radiance() const {
  if (radiance_.texture == kNone<TextureId>) return radiance_.value;
  double sum[3] = {}, weights = 0;
  for (std::size_t i = 0; i < kPowerPoints; ++i) {
    const float stratum = (static_cast<float>(i) + 0.5f) / kPowerPoints;
    const Sample on = sample(stratum, even_point(i));
    const Rgb c = radiance(on.at.uv);
    const double w = 1 / (double(on.pdf_area) * area_);
    sum[0] += w * c.r, sum[1] += w * c.g, sum[2] += w * c.b, weights += w;
  }
  const Rgb found{static_cast<float>(sum[0] / weights), static_cast<float>(sum[1] / weights),
                  static_cast<float>(sum[2] / weights)};
  if (!is_black(found)) return found;
  return radiance_.value * average(scene_.textures[index(radiance_.texture)]);  // small bright spots were missed
}

namespace {

std::vector<float> triangle_areas(const Mesh& mesh) {
  std::vector<float> areas(mesh.n_triangles());
  for (std::size_t k = 0; k < areas.size(); ++k) {
    const std::uint32_t* corner = &mesh.indices[3 * k];
    const Point3d a = widen(mesh.positions[corner[0]]), b = widen(mesh.positions[corner[1]]),
                  c = widen(mesh.positions[corner[2]]);
    areas[k] = static_cast<float>(
        0.5 * norm(cross({b[0] - a[0], b[1] - a[1], b[2] - a[2]}, {c[0] - a[0], c[1] - a[1], c[2] - a[2]})));
  }
  return areas;
}

double cylinder_density(const Transform& to_world, double phi) {
  const Point3d tangent = transform_vector(to_world, {-std::sin(phi), std::cos(phi), 0});
  return kTwoPi * norm(cross(tangent, column(to_world, 2)));
}

Vec2 even_point(std::size_t i) {
  const auto fraction = [](double x) { return static_cast<float>(x - std::floor(x)); };
  const double n = static_cast<double>(i) + 0.5;
  return {fraction(n * 0.7548776662466927), fraction(n * 0.5698402909980532)};
}

}  // namespace

}  // namespace myrialux
