// Files that stand under their name whole or not at all: written beside the target, then renamed.
#pragma once

#include <string>
#include <string_view>

namespace myrialux {

/// Throws Error (output) when `path` cannot be written: its folder is missing, is no folder or is closed to writing, or
/// `path` is a folder. Call it before long work; creates nothing.
void require_writable(const std::string& path);

/// A file under a temporary name in the folder of `path`. Gone with the object unless committed. What is no plain file
/// (/dev/null, a pipe) is written in place.
class OutputFile {
 public:
  /// Creates the temporary file, empty. @throws Error (output) as require_writable
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where to write; has the extension of `path`.
  const std::string& temporary() const { return temporary_; }
  /// Forces the bytes to disk and gives them their name. @throws Error (output)
  void commit();

 private:
  std::string path_, target_, temporary_;  ///< target_: path_ with symbolic links resolved
  bool in_place_ = false, committed_ = false;
};

/// Writes all bytes, or throws Error (output) and leaves what was there before.
void write_file(const std::string& path, std::string_view bytes);

}  // namespace myrialux
