// Files that appear whole under their final name, or not at all.
#include "myrialux/base/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "myrialux/base/error.h"

namespace myrialux {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::output, path + ": cannot be written: " + reason);
}

std::string system_reason(int code) {
  if (code == ENOSPC || code == EDQUOT) return "the disk is full; free some space or choose another folder";
  if (code == EFBIG) return "the file grew beyond the size allowed here (ulimit -f)";
  return std::strerror(code);
}

/// What a symbolic link points at, so that renaming does not replace the link.
fs::path resolve_link(const std::string& path) {
  std::error_code none;
  const fs::path given(path);
  return fs::is_symlink(given, none) ? fs::weakly_canonical(given, none) : given;
}

fs::path folder_of(const fs::path& target) { return target.has_parent_path() ? target.parent_path() : fs::path("."); }

bool is_special(const fs::path& target) {
  std::error_code none;
  const fs::file_status status = fs::status(target, none);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// Closes a file descriptor at the end of a block.
struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
};

}  // namespace

void require_writable(const std::string& path) {
  if (path.empty()) refuse("''", "no file name was given");
  const fs::path target = resolve_link(path), folder = folder_of(target);
  std::error_code none;
  if (fs::is_directory(target, none)) refuse(path, "it is a folder; name a file in it");
  if (!fs::exists(folder, none))
    refuse(path, fmt::format("the folder {0} does not exist; create it (mkdir -p {0})", folder.string()));
  if (!fs::is_directory(folder, none)) refuse(path, folder.string() + " is not a folder");
  if (fs::exists(target, none) && access(target.c_str(), W_OK) != 0)
    refuse(path, fmt::format("{}; change its permissions or choose another name", std::strerror(errno)));
  if (!is_special(target) && access(folder.c_str(), W_OK | X_OK) != 0)
    refuse(path, fmt::format("the folder {}: {}; choose another folder", folder.string(), std::strerror(errno)));
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  require_writable(path);
  const fs::path target = resolve_link(path);
  target_ = target.string();
  if (is_special(target)) {
    in_place_ = true, temporary_ = target_;
    return;
  }
  static std::atomic<unsigned> counter{0};
  do {
    const std::string name =
        fmt::format(".{}.{}-{}.part{}", target.stem().string(), getpid(), counter++, target.extension().string());
    temporary_ = (folder_of(target) / name).string();
    const Descriptor file{open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666)};
    if (file.fd >= 0) return;
  } while (errno == EEXIST);
  refuse(path, system_reason(errno));
}

OutputFile::~OutputFile() {
  if (!in_place_ && !committed_) unlink(temporary_.c_str());
}

void OutputFile::commit() {
  if (!in_place_) {
    const Descriptor file{open(temporary_.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.fd < 0 || fsync(file.fd) != 0) refuse(path_, system_reason(errno));
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) refuse(path_, system_reason(errno));
    // The new name itself; some file systems cannot do this for folders, and the file is whole without.
    const Descriptor folder{open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    if (folder.fd >= 0) (void)fsync(folder.fd);
  }
  committed_ = true;
}

void write_file(const std::string& path, std::string_view bytes) {
  OutputFile output(path);
  {
    const Descriptor file{open(output.temporary().c_str(), O_WRONLY | O_CLOEXEC)};
    if (file.fd < 0) refuse(path, system_reason(errno));
    while (!bytes.empty()) {
      const ssize_t n = write(file.fd, bytes.data(), bytes.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) refuse(path, system_reason(errno));
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  output.commit();
}

}  // namespace myrialux
