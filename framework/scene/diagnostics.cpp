// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/diagnostics.h"

#include <algorithm>
#include <cctype>

#include "framework/scene/text.h"

namespace stroma {

namespace {

/// A broken scene of many megabytes must not turn into as many messages.
constexpr std::size_t kept_problems = 1000;

char lower(char c) { return char(std::tolower(static_cast<unsigned char>(c))); }

/// Insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b`, case ignored.
int editDistance(std::string_view a, std::string_view b) {
  std::vector<int> before(b.size() + 1), previous(b.size() + 1), current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) previous[j] = int(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = int(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substitution = previous[j - 1] + (lower(a[i - 1]) != lower(b[j - 1]));
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]))
        current[j] = std::min(current[j], before[j - 2] + 1);
    }
    before = previous;
    previous = current;
  }
  return previous[b.size()];
}

bool startsWithIgnoringCase(std::string_view text, std::string_view start) {
  return text.size() >= start.size() &&
         std::equal(start.begin(), start.end(), text.begin(), [](char a, char b) { return lower(a) == lower(b); });
}

const char* severityText(Severity severity) {
  return severity == Severity::note ? "note" : severity == Severity::warning ? "warning" : "error";
}

}  // namespace

std::string SourceLocation::text() const {
  std::string out = file;
  if (line > 0) out += ":" + std::to_string(line);
  if (line > 0 && column > 0) out += ":" + std::to_string(column);
  return out;
}

std::string Problem::text() const {
  std::string out = where.text();
  if (!out.empty()) out += ": ";
  out += severityText(severity);
  out += ": ";
  if (!path.empty()) out += path + ": ";
  out += message;
  std::string hint;
  if (!expected.empty()) hint = "expected " + expected;
  if (!suggestion.empty()) {
    if (!hint.empty()) hint += "; ";
    // One word is a name that was nearly written; more is advice.
    const bool is_name = suggestion.find(' ') == std::string::npos;
    hint += is_name ? "did you mean '" + suggestion + "'?" : suggestion;
  }
  if (!hint.empty()) out += " (" + hint + ")";
  return out;
}

void Diagnostics::add(Problem problem) {
  if (problem.severity == Severity::error) ++errors_;
  if (problems_.size() < kept_problems) {
    problems_.push_back(std::move(problem));
  } else if (problems_.size() == kept_problems) {
    problems_.push_back({Severity::note, {}, {}, "there are more errors than these; they are not listed", {}, {}});
  }
}

void Diagnostics::error(SourceLocation where, std::string path, std::string message, std::string expected, std::string suggestion) {
  add({Severity::error, std::move(where), std::move(path), std::move(message), std::move(expected), std::move(suggestion)});
}

void Diagnostics::warning(SourceLocation where, std::string path, std::string message, std::string suggestion) {
  add({Severity::warning, std::move(where), std::move(path), std::move(message), {}, std::move(suggestion)});
}

void Diagnostics::note(SourceLocation where, std::string path, std::string message) {
  add({Severity::note, std::move(where), std::move(path), std::move(message), {}, {}});
}

std::string Diagnostics::text() const {
  std::string out;
  for (const Problem& problem : problems_) out += problem.text() + "\n";
  return out;
}

SceneError::SceneError(Diagnostics diagnostics) : std::runtime_error(diagnostics.text()), diagnostics_(std::move(diagnostics)) {}

ComponentError::ComponentError(const std::string& message, std::string expected_, std::string suggestion_)
    : std::runtime_error(message), expected(std::move(expected_)), suggestion(std::move(suggestion_)) {}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  const std::string* best = nullptr;
  int best_distance = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t longer = std::max(word.size(), candidate.size()), shorter = std::min(word.size(), candidate.size());
    if ((longer - shorter) * 10 > longer * 4) continue;  // also keeps the cost of a huge word at nothing
    const int distance = editDistance(word, candidate);
    if (std::size_t(distance) * 10 > longer * (startsWithIgnoringCase(candidate, word.substr(0, 3)) ? 5 : 4)) continue;
    if (!best || distance < best_distance) best = &candidate, best_distance = distance;
  }
  if (best || word.size() < 4) return best ? *best : std::string();
  for (const std::string& candidate : candidates)
    if (startsWithIgnoringCase(candidate, word) || (candidate.size() >= 4 && startsWithIgnoringCase(word, candidate)))
      if (!best || candidate.size() < best->size()) best = &candidate;
  return best ? *best : std::string();
}

std::string inQuotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out = "'";
  for (char c : text.substr(0, longest)) out += (c == '\n' || c == '\r' || c == '\t') ? ' ' : c;
  return out + (text.size() > longest ? "...'" : "'");
}

}  // namespace stroma
