// SPDX-License-Identifier: LGPL-2.1-or-later
// Profiling spans: where a piece of work begins and ends, and which component it belongs to. Without a listener a span
// costs two tests of one pointer.
#pragma once
namespace stroma {
class Component;

class SpanListener {
 public:
  virtual ~SpanListener() = default;
  /// Called from any thread; spans of one thread are nested. `what` is a literal, `whose` may be null.
  virtual void begin(const char* what, const Component* whose) = 0;
  virtual void end(long count) = 0;  ///< ends the innermost span of this thread; count: iterations of a solve, otherwise 0
};
extern SpanListener* span_listener;  ///< null: none. Not changed while a span is open

/// A span for the lifetime of this object.
class Span {
 public:
  explicit Span(const char* what, const Component* whose = nullptr) {
    if (span_listener) [[unlikely]] span_listener->begin(what, whose);
  }
  Span(const Span&) = delete;
  ~Span() {
    if (span_listener) [[unlikely]] span_listener->end(count_);
  }
  void count(long iterations) { count_ = iterations; }

 private:
  long count_ = 0;
};

/// heard("force", field)->addForce(...) is one call in a span.
template <class Role>
struct Heard {
  Role* operator->() const { return role; }
  Role* role;
  Span span;
};
template <class Role>
Heard<Role> heard(const char* what, Role* role) {
  return {role, Span(what, role)};
}
}  // namespace stroma
