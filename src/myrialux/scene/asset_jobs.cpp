// Loads queued meshes and images in parallel; results and messages keep the order of naming.
#include "myrialux/scene/asset_jobs.h"

#include <fmt/format.h>

#include <filesystem>

#include "myrialux/base/parallel.h"
#include "myrialux/scene/image_io.h"
#include "myrialux/scene/mesh.h"

namespace myrialux {

namespace {

struct MeshResult {
  Diagnostics found;
  std::uint64_t n_dropped = 0;
};

void load_mesh(const MeshJob& job, Mesh& mesh, MeshResult& result);

}  // namespace

std::shared_ptr<const Image> AssetJobs::add_image(const std::string& path, bool raw, float gamma,
                                                  const TextPosition& at) {
  const auto [place, is_new] = image_of_.try_emplace(fmt::format("{}|{}|{}", path, raw, gamma), images_.size());
  if (is_new) images_.push_back({path, at, raw, gamma, std::make_shared<Image>()});
  return images_[place->second].image;
}

void AssetJobs::load(Scene& scene, Diagnostics& found) {
  std::vector<MeshResult> results(meshes_.size());
  std::vector<std::string> wrong(images_.size());
  // Images first: one of them may take longer than many meshes.
  parallel_for(images_.size() + meshes_.size(), [&](std::size_t i) {
    if (i < images_.size()) {
      ImageJob& job = images_[i];
      if (auto image = read_image(job.path, job.raw, job.gamma, wrong[i])) *job.image = std::move(*image);
    } else {
      const MeshJob& job = meshes_[i - images_.size()];
      load_mesh(job, scene.meshes[index(job.mesh)], results[i - images_.size()]);
    }
  });
  for (std::size_t i = 0; i < images_.size(); ++i)
    if (!wrong[i].empty()) found.error(images_[i].at, fmt::format("image {} {}", images_[i].path, wrong[i]));
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    for (const Diagnostic& d : results[i].found.all()) found.add(d.at, d.severity, d.message);
    scene.dropped_triangles += results[i].n_dropped;
    if (results[i].n_dropped > 0)
      found.warning(meshes_[i].at, fmt::format("mesh \"{}\": {} triangles without area were dropped",
                                               scene.meshes[index(meshes_[i].mesh)].name, results[i].n_dropped));
  }
}

std::string AssetJobs::inventory() const {
  std::string list;
  const auto add_file = [&](const std::string& path) {
    std::error_code code;
    const std::uintmax_t size = std::filesystem::file_size(path, code);
    list += fmt::format("{} {}\n", std::filesystem::path(path).filename().string(), code ? 0 : size);
  };
  for (const MeshJob& job : meshes_)
    if (!job.path.empty()) add_file(job.path);
  for (const ImageJob& job : images_) add_file(job.path);
  return list;
}

namespace {

void load_mesh(const MeshJob& job, Mesh& mesh, MeshResult& result) {
  std::string name = mesh.name;
  if (job.format == MeshJob::Format::ply) mesh = read_ply(job.path, result.found);
  if (job.format == MeshJob::Format::obj) mesh = read_obj(job.path, result.found);
  if (job.format == MeshJob::Format::serialized) mesh = read_serialized(job.path, job.shape_index, result.found);
  mesh.name = std::move(name);
  if (result.found.has(Severity::error)) {
    mesh.indices.clear();
    return;
  }
  result.n_dropped = finish_mesh(mesh, {job.to_world, job.face_normals, job.flip_v, job.smooth});
  if (const std::size_t v = first_non_finite(mesh); v < mesh.positions.size()) {
    result.found.error(job.at, fmt::format("mesh \"{}\": vertex {} is too far away once transformed", mesh.name, v));
    mesh.indices.clear();
  }
}

}  // namespace

}  // namespace myrialux
