// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/component.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <new>

#include "framework/scene/problem_listener.h"
#include "framework/scene/spans.h"

namespace stroma {

SpanListener* span_listener = nullptr;

namespace {

/// A component whose initialisation is under way, and the attribute it is fetching, if any.
struct Frame {
  const Component* component;
  const Data* fetching;
};

/// Who waits for whom, to print a circle. Empty whenever no scene is being initialised.
thread_local std::vector<Frame> under_way;

std::string chainTo(const Component& component) {
  std::string chain;
  bool inside = false;
  for (const Frame& frame : under_way) {
    inside = inside || frame.component == &component;
    if (!inside) continue;
    chain += frame.component->path() + (frame.fetching ? "." + frame.fetching->name() : "") + " -> ";
  }
  return chain + component.path();
}

/// Memory that this process may still take [MB]; at most what the machine has.
double memoryLeft() {
  double pages = 0, page = double(sysconf(_SC_PAGESIZE));
  std::ifstream("/proc/self/statm") >> pages;
  rlimit most{};
  getrlimit(RLIMIT_AS, &most);
  return std::min(double(most.rlim_cur) - pages * page, double(sysconf(_SC_PHYS_PAGES)) * page) / 1048576;
}

}  // namespace

std::string Component::path() const {
  if (!node_) return name_;
  const std::string parent = node_->path();
  return parent == "/" ? "/" + name_ : parent + "/" + name_;
}

void Component::ensureReady() {
  if (stage_ == Stage::ready) return;
  if (stage_ == Stage::failed) throw DependencyFailed(path() + " could not be initialised");
  if (stage_ == Stage::initialising)
    throw ComponentError("circular dependency between components: " + chainTo(*this), {},
                         "break the circle by giving one of the values directly");
  stage_ = Stage::initialising;
  under_way.push_back({this, nullptr});
  try {
    const Span span("init", this);
    copyLinkedValues();
    init();
    stage_ = Stage::ready;
    under_way.pop_back();
  } catch (...) {
    under_way.pop_back();
    stage_ = Stage::failed;
    if (!diagnostics_) throw;
    try {
      throw;
    } catch (const DependencyFailed&) {
      throw;
    } catch (const ComponentError& error) {
      reportFailure(error.what(), error.expected, error.suggestion);
    } catch (const std::bad_alloc&) {
      reportFailure(fmt::format("it needs more than {:.0f} MB of memory, which are not available", memoryLeft()),
                    "a smaller mesh, or more memory", {});
    } catch (const std::exception& error) {
      reportFailure(error.what(), {}, {});
    }
    throw DependencyFailed(path() + " could not be initialised");
  }
}

void Component::copyLinkedValues() {
  for (const DataLink& link : data_links_) {
    under_way.back().fetching = link.target;
    link.source->ensureReady();
    if (link.by_src && !link.from->isSet() && !link.from->isOutput()) continue;
    std::optional<Problem> problem = link.target->copyFrom(*link.from);
    if (!problem) continue;
    if (!diagnostics_) throw ComponentError(problem->message, problem->expected, problem->suggestion);
    problem->where = link.where;
    problem->path = path() + "." + link.target->name();
    problem->message += ", linked from " + link.source->path();
    diagnostics_->add(std::move(*problem));
    throw DependencyFailed(path() + " could not be initialised");
  }
  under_way.back().fetching = nullptr;
}

void Component::reportFailure(const std::string& message, const std::string& expected, const std::string& suggestion) const {
  diagnostics_->error(where_, path(), message, expected, suggestion);
}

void Component::standBeside(const Component& other, std::string name) {
  type_ = name;
  name_ = std::move(name);
  node_ = other.node_;
  where_ = other.where_;
  stage_ = Stage::ready;
}

void Component::warn(std::string message, std::string suggestion) const {
  if (diagnostics_) return diagnostics_->warning(where_, path(), std::move(message), std::move(suggestion));
  problem_listener({Severity::warning, where_, path(), std::move(message), {}, std::move(suggestion)});
}

void Component::inform(std::string message) const {
  if (diagnostics_) return diagnostics_->note(where_, path(), std::move(message));
  problem_listener({Severity::note, where_, path(), std::move(message), {}, {}});
}

}  // namespace stroma
