// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace stroma {

/// Where a piece of a scene was written. line and column count from 1; 0 means "not from a file" (an override, a test).
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column", "file:line" or "file"; empty when nothing is known.
  std::string text() const;
};

enum class Severity { note, warning, error };

/// One finding about a scene. Everything but `message` may be empty.
struct Problem {
  Severity severity = Severity::error;
  SourceLocation where;
  std::string path;        ///< path in the tree: "/liver/fem.method"
  std::string message;     ///< what is wrong
  std::string expected;    ///< what was expected
  std::string suggestion;  ///< the nearest right name or the fix

  /// One line: "file:line:column: error: /path: message (expected ...; did you mean ...?)".
  std::string text() const;
};

/// Collects every problem of a scene so that they are reported together.
class Diagnostics {
 public:
  void add(Problem problem);
  void error(SourceLocation where, std::string path, std::string message, std::string expected = {},
             std::string suggestion = {});
  void warning(SourceLocation where, std::string path, std::string message, std::string suggestion = {});
  void note(SourceLocation where, std::string path, std::string message);

  bool hasErrors() const { return errors_ > 0; }
  int errorCount() const { return errors_; }
  const std::vector<Problem>& problems() const { return problems_; }

  /// All problems, one line each.
  std::string text() const;

 private:
  std::vector<Problem> problems_;
  int errors_ = 0;
};

/// Thrown at load boundaries after all problems have been collected.
class SceneError : public std::runtime_error {
 public:
  explicit SceneError(Diagnostics diagnostics);
  const Diagnostics& diagnostics() const { return diagnostics_; }

 private:
  Diagnostics diagnostics_;
};

/// Thrown by a component's init() (or functions it calls) if the component is not valid as written. The loader adds location
/// and path, and continues with the other components.
class ComponentError : public std::runtime_error {
 public:
  explicit ComponentError(const std::string& message, std::string expected = {}, std::string suggestion = {});
  std::string expected;
  std::string suggestion;
};

/// The candidate nearest to `word` by edit distance (case ignored), or empty when none is near enough to help.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace stroma
