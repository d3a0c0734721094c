// SPDX-License-Identifier: LGPL-2.1-or-later
// Positions, velocities and forces of one state over time, in the text of SOFA's WriteState:
//   # stroma state
//   T= 0.01
//     X= x0 y0 z0 x1 y1 z1 ...
//     V= ...
//     @pressures= ...
//   # whole 1a2b3c4d
//   # end
// Numbers have the fewest digits that read back to the same bits. `whole` ends an instant with the CRC-32 of its lines,
// `end` ends the file. Lines with @ are numbers that a component has computed, in a file of its own. Compressed when the name
// ends in ".gz": each instant is a gzip member of its own. Files without the first line, as SOFA and people write them, are read
// as they are.
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

/// One stored instant. A list is empty when its line was not in the file.
struct StateFrame {
  double time = 0;       ///< [s]
  std::vector<Vec3> x0;  ///< rest positions [m]
  std::vector<Vec3> x;   ///< positions [m]
  std::vector<Vec3> v;   ///< velocities [m/s]
  std::vector<Vec3> f;   ///< forces [N]
  std::map<std::string, std::vector<double>> values{};  ///< of lines with @, by name
};

/// Writes a state file. An instant is in the file from its finish() on, whatever happens to the process or to the disk
/// afterwards. A file of the same name loses what it has with the first instant, not before. Every call throws
/// OutputError on failure; after that no call has an effect.
class StateWriter {
 public:
  /// Opens the file, and makes its folder.
  explicit StateWriter(const std::string& path);
  StateWriter(StateWriter&&) noexcept;
  ~StateWriter();

  const std::string& path() const;
  /// A run that goes on at time `t` [s]: keeps the instants that the file has up to there; `at_t`: that of `t` too. Not
  /// after the first time(). Returns the time of the last one kept. Throws as readRecording(), and when the file has
  /// instants that were written in another way.
  std::optional<double> goOn(double t, bool at_t, const State* state = nullptr);
  void time(double t);  ///< starts the instant at time t [s]
  /// A line of the instant: label is "X", "X0", "V" or "F".
  void rows(std::string_view label, ConstRows rows);
  void rows(std::string_view label, const std::vector<Vec3>& rows);
  /// Only the rows listed in `indices`.
  void rows(std::string_view label, ConstRows rows, const std::vector<int>& indices);
  /// Those of a state, by what they are: a point has 3 numbers, a number 1, an orientation 4 ("X": x y z w), else 3. Only
  /// `nodes`, where some are listed.
  void rows(std::string_view label, const State& state, ConstRows rows, const std::vector<int>& nodes = {});
  void values(std::string_view name, const std::vector<double>& numbers);  ///< a line with @
  void finish();  ///< the instant is whole
  void close();   ///< the recording is whole

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a state file holds.
struct StateRecording {
  std::vector<StateFrame> frames;  ///< whole ones
  std::string unfinished;  ///< a sentence with the last whole instant when the file has no end: a run still writes it,
                           ///< was killed, or the file was cut short
  std::vector<std::uint64_t> ends;  ///< byte where each instant ends in the file; empty for files of others
  static constexpr std::uint64_t inside_piece = ~std::uint64_t(0);  ///< such an end, in a file compressed by others
};

/// Reads all whole instants; with a state, of rows as it has them, else of points. Values are as in State::position.
/// Throws std::runtime_error naming file and line when the file is missing, damaged, not of
/// this format, or without marks and cut short. Numbers that are not finite are read as they are: what they mean is the
/// caller's to say.
StateRecording readRecording(const std::string& path, const State* state = nullptr);

/// The instants of a finished file. Throws as readRecording(), and when the file is not finished.
std::vector<StateFrame> readStateFile(const std::string& path, const State* state = nullptr);

/// The file that holds the recording of a state: the state's path in the tree without the first "/", other "/" turned
/// into ".", and the ending: "/liver/dofs" gives "liver.dofs.state.gz".
std::string stateFileName(std::string_view state_path);

/// The fewest digits that read back to the same bits, appended to `text`.
void appendNumber(std::string& text, double number);

}  // namespace stroma
