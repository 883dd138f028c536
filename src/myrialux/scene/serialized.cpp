// Reads the binary mesh files of Mitsuba 0.5/0.6 (.serialized, versions 3 and 4, compressed by zlib).
#include <fmt/format.h>
#include <zlib.h>

#include <cstring>
#include <optional>
#include <string_view>

#include "myrialux/scene/mesh.h"
#include "myrialux/scene/text.h"

namespace myrialux {

namespace {

constexpr std::uint16_t kMagic = 0x041c;
enum Flags : std::uint32_t {
  kNormals = 0x1,
  kUvs = 0x2,
  kColors = 0x8,
  kFaceNormals = 0x10,
  kSingle = 0x1000,
  kDouble = 0x2000
};

struct Broken {
  std::string what;
};

template <class T>
T take(std::string_view bytes, std::size_t at) {
  T value;
  if (at > bytes.size() || bytes.size() - at < sizeof(T))
    throw Broken{fmt::format("byte {}: the file ends too early", at)};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// Inflates as it is read, so that a header's promises cost nothing.
class Inflater {
 public:
  explicit Inflater(std::string_view bytes) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream_.avail_in = static_cast<uInt>(std::min<std::size_t>(bytes.size(), 0xffffffffu));
    if (inflateInit(&stream_) != Z_OK) throw Broken{"zlib cannot start"};
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  void read(void* to, std::size_t n);
  template <class T>
  T next() {
    T value;
    read(&value, sizeof(T));
    return value;
  }
  /// Checks the end of the stream and its checksum.
  void finish();
  /// Upper bound of the bytes still to come: zlib packs at most 1032 to 1.
  std::uint64_t at_most_left() const { return std::uint64_t{stream_.avail_in} * 1032 + (1u << 16); }

 private:
  z_stream stream_{};
};

std::string_view chunk_of(std::string_view bytes, int shape_index, std::uint16_t& version);
Mesh read_chunk(Inflater& in, std::uint16_t version);

}  // namespace

Mesh read_serialized(const std::string& path, int shape_index, Diagnostics& found) {
  const std::optional<std::string> bytes = read_file(path);
  if (!bytes) return found.error({path, 0, 0}, "cannot be read"), Mesh{};
  try {
    std::uint16_t version = 0;
    Inflater in(chunk_of(*bytes, shape_index, version));
    Mesh mesh = read_chunk(in, version);
    for (const std::uint32_t v : mesh.indices)
      if (v >= mesh.positions.size())
        throw Broken{fmt::format("a face names vertex {}; allowed: 0 to {}", v,
                                 static_cast<std::int64_t>(mesh.positions.size()) - 1)};
    if (const std::size_t v = first_non_finite(mesh); v < mesh.positions.size())
      throw Broken{fmt::format("vertex {} is not finite", v)};
    return mesh;
  } catch (const Broken& broken) {
    found.error({path, 0, 0}, broken.what);
  }
  return {};
}

namespace {

/// The packed bytes of one mesh: the file ends with the offsets of all meshes and their number.
std::string_view chunk_of(std::string_view bytes, int shape_index, std::uint16_t& version) {
  if (bytes.size() < 8 || take<std::uint16_t>(bytes, 0) != kMagic)
    throw Broken{"not a serialized mesh file of Mitsuba"};
  const std::uint32_t n_meshes = take<std::uint32_t>(bytes, bytes.size() - 4);
  version = take<std::uint16_t>(bytes, 2);
  if (version != 3 && version != 4) throw Broken{fmt::format("version is {}; allowed: 3, 4", version)};
  if (shape_index < 0 || static_cast<std::uint32_t>(shape_index) >= n_meshes)
    throw Broken{fmt::format("shape index is {}; allowed: 0 to {}", shape_index, std::int64_t{n_meshes} - 1)};
  const std::size_t width = version == 4 ? 8 : 4;
  const std::uint64_t table_size = std::uint64_t{n_meshes} * width + 4;
  if (table_size > bytes.size()) throw Broken{fmt::format("the table of {} meshes is larger than the file", n_meshes)};
  const std::size_t table = bytes.size() - table_size;
  const auto offset_of = [&](std::size_t i) -> std::uint64_t {
    if (i == n_meshes) return table;
    return width == 8 ? take<std::uint64_t>(bytes, table + i * 8) : take<std::uint32_t>(bytes, table + i * 4);
  };
  const std::uint64_t start = offset_of(shape_index), end = offset_of(shape_index + 1);
  if (start > bytes.size() || end > bytes.size() || end < start || end - start < 4)
    throw Broken{fmt::format("byte {}: the table of meshes points outside the file", table)};
  if (take<std::uint16_t>(bytes, start) != kMagic) throw Broken{fmt::format("byte {}: no mesh starts here", start)};
  version = take<std::uint16_t>(bytes, start + 2);
  return bytes.substr(start + 4, end - start - 4);
}

void Inflater::read(void* to, std::size_t n) {
  stream_.next_out = static_cast<Bytef*>(to);
  while (n > 0) {
    stream_.avail_out = static_cast<uInt>(std::min<std::size_t>(n, 1u << 30));
    const uInt before = stream_.avail_out;
    const int code = inflate(&stream_, Z_SYNC_FLUSH);
    const std::size_t got = before - stream_.avail_out;
    n -= got;
    if (n > 0 && (code == Z_STREAM_END || (code == Z_BUF_ERROR && got == 0)))
      throw Broken{fmt::format("packed data end too early, after {} bytes", stream_.total_out)};
    if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
      throw Broken{fmt::format("packed data are damaged after {} bytes: {}", stream_.total_out,
                               stream_.msg ? stream_.msg : "zlib error")};
  }
}

void Inflater::finish() {
  Bytef spare;
  stream_.next_out = &spare, stream_.avail_out = 1;
  if (inflate(&stream_, Z_FINISH) != Z_STREAM_END)
    throw Broken{fmt::format("packed data are damaged after {} bytes: {}", stream_.total_out,
                             stream_.msg ? stream_.msg : "they do not end where they should")};
}

template <class Out>
void read_array(Inflater& in, bool is_double, std::size_t n_numbers, Out&& out) {
  std::vector<double> wide(is_double ? n_numbers : 0);
  std::vector<float> narrow(is_double ? 0 : n_numbers);
  if (is_double)
    in.read(wide.data(), n_numbers * sizeof(double));
  else
    in.read(narrow.data(), n_numbers * sizeof(float));
  for (std::size_t i = 0; i < n_numbers; ++i) out(i, is_double ? static_cast<float>(wide[i]) : narrow[i]);
}

Mesh read_chunk(Inflater& in, std::uint16_t version) {
  Mesh mesh;
  const std::uint32_t flags = in.next<std::uint32_t>();
  if (version == 4)
    for (std::size_t length = 0; in.next<char>() != '\0'; ++length)
      if (length > 4096) throw Broken{"the name of the mesh does not end"};
  const std::uint64_t n_vertices = in.next<std::uint64_t>(), n_triangles = in.next<std::uint64_t>();
  const std::uint64_t bound = in.at_most_left() / 12;
  if (n_vertices > bound || n_triangles > bound || n_vertices > 0xffffffffu)
    throw Broken{
        fmt::format("{} vertices and {} triangles are promised, more than the file can hold", n_vertices, n_triangles)};
  const bool is_double = flags & kDouble;
  if (is_double == bool(flags & kSingle)) throw Broken{fmt::format("flags {:#x}: single or double precision?", flags)};
  const auto read_vec3 = [&](std::vector<Vec3>& to) {
    to.resize(n_vertices);
    read_array(in, is_double, 3 * n_vertices, [&](std::size_t i, float x) { to[i / 3][static_cast<int>(i % 3)] = x; });
  };
  read_vec3(mesh.positions);
  if (flags & kNormals) read_vec3(mesh.normals);
  if (flags & kUvs) {
    mesh.uvs.resize(n_vertices);
    read_array(in, is_double, 2 * n_vertices,
               [&](std::size_t i, float x) { (i % 2 ? mesh.uvs[i / 2].y : mesh.uvs[i / 2].x) = x; });
  }
  if (flags & kColors) read_array(in, is_double, 3 * n_vertices, [](std::size_t, float) {});
  mesh.indices.resize(3 * n_triangles);
  in.read(mesh.indices.data(), mesh.indices.size() * sizeof(std::uint32_t));
  in.finish();
  return mesh;
}

}  // namespace

}  // namespace myrialux
