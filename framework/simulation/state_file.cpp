// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/state_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <utility>

namespace stroma {
namespace {

constexpr std::size_t flush_at = 1 << 16;  // characters collected before they are handed to zlib

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", path, what));
}

struct Closer {
  void operator()(gzFile_s* file) const { gzclose(file); }
};
using File = std::unique_ptr<gzFile_s, Closer>;

}  // namespace

void appendNumber(std::string& text, double number) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  text.append(digits, end);
}

std::string stateFileName(std::string_view state_path) {
  std::string name(state_path.substr(std::min(state_path.size(), state_path.find_first_not_of('/'))));
  std::replace(name.begin(), name.end(), '/', '.');
  return name + ".state.gz";
}

// ---- writing ----

struct StateWriter::Impl {
  std::string path, partial, text;
  File file;

  void flush(std::size_t threshold = 0) {
    if (text.size() <= threshold) return;
    if (gzwrite(file.get(), text.data(), unsigned(text.size())) != int(text.size()))
      fail(partial, fmt::format("cannot write ({})", std::strerror(errno)));
    text.clear();
  }
  template <class Point>
  void line(std::string_view label, std::size_t count, Point point) {
    text.append("  ").append(label).append("=");
    for (std::size_t i = 0; i < count; ++i) {
      const auto p = point(i);
      for (int c = 0; c < 3; ++c) appendNumber(text += ' ', p[c]);
      flush(flush_at);
    }
    text += '\n';
  }
};

StateWriter::StateWriter(std::string path) : impl_(std::make_unique<Impl>()) {
  impl_->path = std::move(path);
  impl_->partial = impl_->path + ".part";
  const std::filesystem::path folder = std::filesystem::path(impl_->path).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) fail(folder.string(), "cannot make the folder (" + error.message() + ")");
  // level 1: recording must not slow the steps, and digits hardly compress better at a higher level
  impl_->file.reset(gzopen(impl_->partial.c_str(), impl_->path.ends_with(".gz") ? "wb1" : "wbT"));
  if (!impl_->file) fail(impl_->partial, fmt::format("cannot open for writing ({})", std::strerror(errno)));
}

StateWriter::StateWriter(StateWriter&&) noexcept = default;

StateWriter::~StateWriter() {
  if (!impl_ || !impl_->file) return;
  impl_->file.reset();
  std::remove(impl_->partial.c_str());
}

const std::string& StateWriter::path() const { return impl_->path; }

void StateWriter::time(double t) {
  appendNumber(impl_->text += "T= ", t);
  impl_->text += '\n';
}

void StateWriter::rows(std::string_view label, ConstRows rows) {
  impl_->line(label, std::size_t(rows.count), [&](std::size_t i) { return rows[Index(i)]; });
}

void StateWriter::rows(std::string_view label, const std::vector<Vec3>& rows) {
  impl_->line(label, rows.size(), [&](std::size_t i) { return rows[i]; });
}

void StateWriter::rows(std::string_view label, ConstRows rows, const std::vector<int>& indices) {
  impl_->line(label, indices.size(), [&](std::size_t i) { return rows[Index(indices[i])]; });
}

void StateWriter::close() {
  impl_->flush();
  if (gzclose(impl_->file.release()) != Z_OK) {
    std::remove(impl_->partial.c_str());
    fail(impl_->partial, "cannot finish writing: is the disk full?");
  }
  std::error_code error;
  std::filesystem::rename(impl_->partial, impl_->path, error);
  if (error) fail(impl_->path, "cannot rename the finished file (" + error.message() + ")");
}

// ---- reading ----

namespace {

std::string readAll(const std::string& path) {
  const File file(gzopen(path.c_str(), "rb"));  // reads plain text as well
  if (!file) fail(path, fmt::format("cannot open ({})", std::strerror(errno)));
  std::string text;
  char buffer[flush_at];
  int count = 0;
  while ((count = gzread(file.get(), buffer, sizeof buffer)) > 0) text.append(buffer, std::size_t(count));
  int code = Z_OK;
  const char* message = gzerror(file.get(), &code);
  if (count < 0 || code == Z_BUF_ERROR) fail(path, fmt::format("the file is cut short or damaged ({})", message));
  return text;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Takes the next number off `text`; false when there is none.
bool takeNumber(std::string_view& text, double& number) {
  text = text.substr(std::min(text.size(), text.find_first_not_of(" \t\r")));
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return false;
  text.remove_prefix(std::size_t(end - text.data()));
  return text.empty() || text.front() == ' ' || text.front() == '\t' || text.front() == '\r';
}

class StateReader {
 public:
  explicit StateReader(const std::string& path) : path_(path) {}

  std::vector<StateFrame> read() {
    const std::string text = readAll(path_);
    std::string_view rest = text;
    while (!rest.empty()) {
      const auto end = rest.find('\n');
      ++line_;
      if (end == std::string_view::npos) complain("the last line has no end: the file is cut short");
      readLine(trimmed(rest.substr(0, end)));
      rest.remove_prefix(end + 1);
    }
    return std::move(frames_);
  }

 private:
  [[noreturn]] void complain(const std::string& what) const { fail(fmt::format("{}:{}", path_, line_), what); }

  void readLine(std::string_view line) {
    if (line.empty() || line.front() == '#') return;
    const auto equals = line.find('=');
    const std::string_view label = line.substr(0, equals);
    const bool known = label == "T" || label == "X" || label == "X0" || label == "V" || label == "F";
    if (equals == std::string_view::npos || !known)
      complain(fmt::format("'{:.20}' is not a line of a state file (expected T=, X=, X0=, V= or F=)", line));
    line.remove_prefix(equals + 1);
    if (label == "T") return readTime(line);
    if (frames_.empty()) complain("values before the first T= line");
    StateFrame& frame = frames_.back();
    readPoints(line, label == "X" ? frame.x : label == "X0" ? frame.x0 : label == "V" ? frame.v : frame.f);
  }

  void readTime(std::string_view line) {
    frames_.emplace_back();
    if (!takeNumber(line, frames_.back().time) || !trimmed(line).empty()) complain("T= must be followed by one number");
  }

  void readPoints(std::string_view line, std::vector<Vec3>& points) {
    if (!points.empty()) complain("the same line twice in one frame");
    while (!trimmed(line).empty()) {
      Vec3& point = points.emplace_back();
      for (int c = 0; c < 3; ++c)
        if (!takeNumber(line, point[c]))
          complain(fmt::format("point {} is not three numbers: the file is cut short or damaged", points.size() - 1));
    }
  }

  const std::string& path_;
  long line_ = 0;
  std::vector<StateFrame> frames_;
};

}  // namespace

std::vector<StateFrame> readStateFile(const std::string& path) { return StateReader(path).read(); }

bool keepInstants(StateWriter& writer, double t) {
  if (!std::filesystem::exists(writer.path())) return false;
  double last = -std::numeric_limits<double>::infinity();
  for (const StateFrame& frame : readStateFile(writer.path())) {
    if (frame.time > t) break;
    writer.time(last = frame.time);
    const std::pair<const char*, const std::vector<Vec3>&> lines[] = {
        {"X0", frame.x0}, {"X", frame.x}, {"V", frame.v}, {"F", frame.f}};
    for (const auto& [label, rows] : lines)
      if (!rows.empty()) writer.rows(label, rows);
  }
  return last == t;
}

}  // namespace stroma
