// SPDX-License-Identifier: LGPL-2.1-or-later
// The role of the module that shows a scene in a browser. It is in a library of its own because of Boost.Beast and the page
// that is built into it; only `stroma view` opens it.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tools/drawing/recording.h"
#include "tools/session/session.h"

namespace stroma::view {

using drawing::Recording;

/// What is to be shown, and to whom.
struct ViewRequest {
  std::string host = "127.0.0.1";  ///< address to listen on
  int port = 0;                    ///< 0: any free one
  bool at_once = false;            ///< run before a page is there to see it
  bool paused = false;             ///< wait for somebody to press "run"
  double fps = 60;                 ///< most pictures a second
  Recording recording{};           ///< not empty: these instants are shown, and nothing is run
  RecordedMeshes meshes{};         ///< of the recording
  /// Origins of pages that may show this one in a frame, as http://localhost:8888 for a notebook; without any, no page may.
  std::vector<std::string> framed_by{};
  std::string build;               ///< of the program; a page of another build is asked to reload

  std::function<void()>
      listening{};  ///< called once, before anything runs: what must not happen where nobody is served
  // Called by the thread that serves:
  std::function<void(const std::string& address)> opened{};  ///< pages may come
  // Called by the thread that steps, between steps:
  /// May throw OutputError: the run ends. A reset whose after_reset threw lets after_step throw until another has not.
  std::function<void()> after_step{}, after_reset{};
  std::function<void()> before_step{};  ///< what it throws ends the run
  std::function<void(const std::string& sentence)> output_failed{};  ///< of an observer, before `ended`
  std::function<void(const std::string& sentence)> ended{};          ///< a step without a result, an output that fails
};

/// How a page that plays a run by itself is made.
struct ExportRequest {
  std::string file;
  long steps = 100;                   ///< to make
  long every = 1;                     ///< steps, or instants of the recording, from one picture to the next
  Recording recording{};              ///< not empty: its instants are shown, and nothing is run
  RecordedMeshes meshes{};            ///< of the recording
  std::vector<std::string> fields{};  ///< names of cell fields that are kept; all nodes' displacements always are
  bool inside = false;                ///< the nodes inside too, so that the body can be cut
  std::function<void()> before_step{}, after_step{};  ///< called by the thread that steps; what they throw ends the run
};

class Viewer {
 public:
  static constexpr const char *role = "viewer", *library = "view",
                              *missing = "run `tools/setup view`, which installs Node.js with npm and builds it";
  virtual ~Viewer() = default;
  /// Serves pages until SIGINT or SIGTERM, and steps the loaded scene in a thread of its own. Returns the number of the
  /// signal. Throws std::runtime_error when it cannot listen.
  virtual int view(Session& session, const ViewRequest& request) const = 0;
  /// Runs the loaded scene, or takes its recording, and writes one HTML file that needs no server. Returns how the run
  /// ended; there is a file only when that is RunEnd::done. Throws OutputError, ComponentError for a field that no body
  /// has, and std::runtime_error as soon as the file has more than 50 MB, with the `every` that fits.
  virtual RunReport writePage(Session& session, const ExportRequest& request) const = 0;
};

}  // namespace stroma::view
