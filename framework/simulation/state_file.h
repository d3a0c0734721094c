// SPDX-License-Identifier: LGPL-2.1-or-later
// Positions, velocities and forces of one state over time, in the text of SOFA's WriteState:
//   # stroma state
//   T= 0.01
//     X= x0 y0 z0 x1 y1 z1 ...
//     V= ...
//     @pressures= ...
//   # whole 1a2b3c4d
//   # end
// Numbers have the fewest digits that read back to the same bits. `whole` ends a frame with the CRC-32 of its lines,
// `end` ends the file. Lines with @ are numbers computed by a component, in a separate file. Compressed if the name
// ends in ".gz": each frame is a gzip member of its own. Files without the first line, written by SOFA or by hand, are read
// too.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// One stored frame. A list is empty if its line was not in the file.
struct StateFrame {
  double time = 0;       ///< [s]
  std::vector<Vec3> x0;  ///< rest positions [m]
  std::vector<Vec3> x;   ///< positions [m]
  std::vector<Vec3> v;   ///< velocities [m/s]
  std::vector<Vec3> f;   ///< forces [N]
  std::map<std::string, std::vector<double>> values{};  ///< of lines with @, by name
};

/// Writes a state file. A frame is safely in the file after its finish(), whatever happens to the process or the disk
/// later. An existing file is truncated by the first frame, not before. Every call throws OutputError on failure;
/// after that, calls have no effect.
class StateWriter {
 public:
  /// Opens the file and creates its folder.
  explicit StateWriter(const std::string& path);
  StateWriter(StateWriter&&) noexcept;
  ~StateWriter();

  const std::string& path() const;
  /// Continues a run at time `t` [s]: keeps the frames in the file before `t`, or up to and including it with `at_t`. Not
  /// after the first time(). Returns the time of the last frame kept. Throws as readRecording() does, and if the file has
  /// frames in a different layout.
  std::optional<double> goOn(double t, bool at_t, const State* state = nullptr);
  void time(double t);  ///< starts the frame at time t [s]
  /// Writes a line of the frame; label is "X", "X0", "V" or "F".
  void rows(std::string_view label, ConstRows rows);
  void rows(std::string_view label, const std::vector<Vec3>& rows);
  /// Only the rows listed in `indices`.
  void rows(std::string_view label, ConstRows rows, const std::vector<int>& indices);
  /// The rows of a state, by kind: a point has 3 numbers, a number 1, an orientation 4 ("X": x y z w) or 3. Only `nodes`,
  /// if some are listed.
  void rows(std::string_view label, const State& state, ConstRows rows, const std::vector<int>& nodes = {});
  void values(std::string_view name, const std::vector<double>& numbers);  ///< a line with @
  void finish();  ///< completes the frame
  void close();   ///< completes the recording

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The contents of a state file.
struct StateRecording {
  std::vector<StateFrame> frames;  ///< complete ones
  std::string unfinished;  ///< a sentence with the last complete frame if the file has no end: a run still writes it,
                           ///< was killed, or the file was truncated
  std::vector<std::uint64_t> ends;  ///< byte offset of the end of each frame; empty for files of other programs
  static constexpr std::uint64_t inside_piece = ~std::uint64_t(0);  ///< an end inside a gzip member of another program
};

/// Reads all complete frames, with the row kinds of a state if given, otherwise as points. Values are as in State::position.
/// Throws std::runtime_error naming file and line if the file is missing, damaged, of another format, or truncated
/// without marks. Non-finite numbers are read as they are; the caller must interpret
/// them.
StateRecording readRecording(const std::string& path, const State* state = nullptr);

/// The frames of a finished file. Throws as readRecording() does, and if the file is not finished.
std::vector<StateFrame> readStateFile(const std::string& path, const State* state = nullptr);

/// The file name of a state's recording: the path of the state without the first "/", with other "/" replaced by
/// ".", and the suffix: "/liver/dofs" gives "liver.dofs.state.gz".
std::string stateFileName(std::string_view state_path);

/// The fewest digits that read back to the same bits, appended to `text`.
void appendNumber(std::string& text, double number);

}  // namespace stroma
