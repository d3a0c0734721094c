// SPDX-License-Identifier: LGPL-2.1-or-later
// The role of the module that disturbs a scene in many ways and says what becomes of it. It is in a library of its own, which
// only `stroma stress` opens.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma::stress {

/// What the user asked for.
struct StressRequest {
  std::string program;               ///< the command, for the digest of the build
  std::string scene, folder;         ///< absolute
  std::vector<Override> overrides;   ///< of all cases
  std::vector<std::string> modules;  ///< files of --module, absolute
  std::optional<long> steps;         ///< of each case; else by the size of the scene
  double seconds = 120;              ///< no case begins later; of wall time
  bool goes_on = false;              ///< --hours: beyond the list, with magnitudes at random
  std::optional<long> cases;         ///< so many at most
  std::optional<long> only;          ///< this case alone, with all it has to say
  unsigned seed = 1;
  int jobs = 1;  ///< cases at once
  bool quiet = false;
  std::string json_file;           ///< "-": standard output; empty: none but the folder's
  std::vector<std::string> words;  ///< the command's arguments as they were given, for the page
};

class Stresser {
 public:
  static constexpr const char *role = "stresser", *library = "stress", *missing = "build it with `ninja stress`";
  virtual ~Stresser() = default;
  /// Returns an exit code of the command: 0, 1 (something breaks), 3 (the scene as it is has no result), 130 or 143
  /// (stopped). Throws SceneError and std::invalid_argument with a sentence for bad input, and OutputError.
  virtual int stress(const StressRequest& request) const = 0;
};

}  // namespace stroma::stress
