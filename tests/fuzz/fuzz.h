// SPDX-License-Identifier: LGPL-2.1-or-later
// A fuzz target is one function of bytes: whatever they are, it comes back, or it says what it found and aborts. libFuzzer
// calls it with bytes that reach new code (STROMA_FUZZ), replay.cpp with the kept files:
//   STROMA_FUZZ_TARGET(name) { ... data, size ...; return 0; }
#pragma once
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "framework/mesh/mesh.h"

namespace stroma::fuzz {

using Target = int(const std::uint8_t* data, std::size_t size);
/// Those of this program, by name.
inline std::map<std::string, Target*>& targets() {
  static std::map<std::string, Target*> all;
  return all;
}

/// What must hold whatever the bytes are.
inline void require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

/// The one file of this process that holds the bytes, for readers that want a path; in memory where the system can.
inline const std::string& fileWith(std::string_view bytes, const std::string& ending = {}) {
  struct File {
    explicit File(const std::string& end) {
      std::error_code none;
      const std::filesystem::path memory = "/dev/shm";
      const auto folder = std::filesystem::is_directory(memory, none) ? memory : std::filesystem::temp_directory_path();
      path = (folder / ("stroma_fuzz_" + std::to_string(getpid()) + end)).string();
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() { std::remove(path.c_str()); }
    std::string path;
  };
  static const File file(ending);
  std::FILE* stream = std::fopen(file.path.c_str(), "wb");
  require(stream && std::fwrite(bytes.data(), 1, bytes.size(), stream) == bytes.size(),
          file.path + " cannot be written");
  std::fclose(stream);
  return file.path;
}

/// Loads the bytes as a mesh through a loader, as a scene does: refused with a sentence, or a mesh in which every cell
/// names nodes that there are. `attributes` of the loader besides the file.
void loadMesh(const std::string& loader, const std::string& ending, std::string_view bytes,
              const std::string& attributes);

}  // namespace stroma::fuzz

#ifdef STROMA_LIBFUZZER  // a program for each
#define STROMA_FUZZ_TARGET(name)                          \
  extern "C" stroma::fuzz::Target LLVMFuzzerTestOneInput; \
  int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
#else
#define STROMA_FUZZ_TARGET(name)                                                              \
  static stroma::fuzz::Target fuzz_##name;                                                    \
  [[maybe_unused]] static const bool has_fuzz_##name =                                        \
      stroma::fuzz::targets().emplace(#name, fuzz_##name).second;                             \
  static int fuzz_##name(const std::uint8_t* data, std::size_t size)
#endif
