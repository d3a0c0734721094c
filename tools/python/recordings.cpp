// SPDX-License-Identifier: LGPL-2.1-or-later
// Recorded runs as arrays.
#include <pybind11/numpy.h>

#include <cstring>

#include "framework/simulation/state_file.h"
#include "tools/python/python.h"

namespace stroma::python {
namespace {

/// The lists of all instants, (instants, rows, 3); none where an instant has none. Throws where instants differ in length.
py::object stacked(const std::string& path, const std::vector<StateFrame>& frames, std::vector<Vec3> StateFrame::*list) {
  if (frames.empty() || (frames.front().*list).empty()) return py::none();
  const std::size_t rows = (frames.front().*list).size();
  py::array_t<double> out({py::ssize_t(frames.size()), py::ssize_t(rows), py::ssize_t(3)});
  double* to = out.mutable_data();
  for (const StateFrame& frame : frames) {
    const std::vector<Vec3>& values = frame.*list;
    if (values.empty()) return py::none();
    if (values.size() != rows) throw std::runtime_error(path + ": instants have different numbers of nodes");
    std::memcpy(to, values.data(), rows * sizeof(Vec3));
    to += 3 * rows;
  }
  return out;
}

py::tuple recording(const std::string& path) {
  const StateRecording read = readRecording(path);
  py::array_t<double> times(py::ssize_t(read.frames.size()));
  for (std::size_t i = 0; i < read.frames.size(); ++i) times.mutable_data()[i] = read.frames[i].time;
  return py::make_tuple(times, stacked(path, read.frames, &StateFrame::x), stacked(path, read.frames, &StateFrame::v),
                        stacked(path, read.frames, &StateFrame::f), read.unfinished);
}

}  // namespace

void bindRecordings(py::module_& module) {
  module.def("recording", &recording);
  module.def("recorded_name", [](const std::string& state) { return stateFileName(state); });
}

}  // namespace stroma::python
