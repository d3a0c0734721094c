// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "framework/scene/data.h"

namespace stroma {

class Archive;
class Node;

/// Base of everything a scene can name. A component declares its parameters once, is initialised once after all that
/// it reads, and is then used through the role it plays (ForceField, Mass, Integrator, ...).
class Component {
 public:
  Component() = default;
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;
  virtual ~Component() = default;

  /// Declares every attribute, once; called by the factory right after construction.
  virtual void declare(DataTable& table) = 0;
  /// Checks the parameters together and prepares what does not change in a step. Called once, when all linked sources
  /// are ready. What it looks up through find...() or a Link is initialised before it is returned, so the order of
  /// the file does not matter. Throws ComponentError.
  virtual void init() {}
  /// Forgets what steps have left behind (a history, a warm start): the simulation goes back to its initial state and
  /// must repeat itself bit for bit. Nothing to do for a component whose steps read only x, v and the time.
  virtual void reset() {}
  /// Writes or reads, under names, everything that steps leave behind and later steps depend on besides x, v and the
  /// time: what reset() forgets. With the values read back, a run goes on with the bits of one that never stopped.
  /// Archive::isReading() tells the direction. Throws std::runtime_error when the values read are those of another scene.
  virtual void serialize(Archive&) {}
  /// An attribute declared recompiled() has a new value while the scene runs: checks it and recomputes what init()
  /// derived from attributes. Compiled roles (force fields, masses) are compiled again afterwards, and what serialize()
  /// knows is kept. Throws ComponentError. Whatever is thrown, the old value is put back and this is called once more.
  virtual void recompile() { init(); }
  /// The attribute `template` as it is written, before any other attribute is read: for a component whose attributes
  /// have other types then (Data::keepIn).
  virtual void chooseTemplate(const std::string&) {}
  /// False when another component of the node stands for this one: searches by role pass it over. Asked before init().
  virtual bool answersLookup() const { return true; }
  /// The type of a component that this one cannot do without and that its node does not hold: it is then made beside it,
  /// with its defaults. Empty: nothing is missing. Asked when all components of the node have read their attributes.
  virtual std::string missingPartner() const { return {}; }
  /// The word for the role, for messages: "force field".
  virtual std::string roleText() const = 0;

  const std::string& type() const { return type_; }
  const std::string& name() const { return name_; }
  const SourceLocation& where() const { return where_; }
  bool isMadeForAnother() const { return is_made_for_another_; }  ///< not in the scene, see missingPartner()
  std::string path() const;  ///< "/liver/fem"
  Node& node() const { return *node_; }
  DataTable& data() { return data_; }
  const DataTable& data() const { return data_; }

  /// Runs init() now unless it has run; used by look-ups. Throws DependencyFailed when it failed before, and
  /// ComponentError with the chain printed when components need each other in a circle.
  void ensureReady();
  bool isReady() const { return stage_ == Stage::ready; }
  bool hasFailed() const { return stage_ == Stage::failed; }
  void markFailed() { stage_ = Stage::failed; }

  /// The component of role `Role` in this node, else (upwards = true) in the nearest ancestor that has one; null when
  /// there is none. Throws ComponentError when a node has several. The result is initialised.
  template <class Role>
  Role* find(bool upwards = false) const;

  /// A warning or a note raised while initialising, shown with this component's location and path.
  void warn(std::string message, std::string suggestion = {}) const;
  void inform(std::string message) const;

 protected:
  /// For what a program adds to a running scene: it is called `name` and stands in the node of `other`, which does not
  /// own it.
  void standBeside(const Component& other, std::string name);

 private:
  friend class Factory;
  friend class Node;
  friend class Instantiation;
  friend class LiveEdit;
  enum class Stage { created, initialising, ready, failed };

  /// `folder_`: where relative file names of this component start.
  std::string type_, name_, folder_;
  SourceLocation where_;
  Node* node_ = nullptr;
  Diagnostics* diagnostics_ = nullptr;
  Stage stage_ = Stage::created;
  bool is_made_for_another_ = false;
  DataTable data_;
  /// An attribute of ours that takes the value of another component's.
  struct DataLink {
    Data* target;
    Component* source;
    const Data* from;
    SourceLocation where;
    bool by_src;  ///< made by `src`: copied only when the source has something to give
  };
  /// Before init(): takes the values of linked attributes, whose components are ready then.
  void copyLinkedValues();
  void reportFailure(const std::string& message, const std::string& expected, const std::string& suggestion) const;

  /// Not owning: source components live as long as the tree.
  std::vector<DataLink> data_links_;
};

/// Thrown when a component needs another one that has already been reported: no second message follows.
class DependencyFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A typed link. `get()` initialises the target before it returns it.
template <class Role>
class Link : public LinkBase {
 public:
  explicit Link(std::string role_text) : role_text_(std::move(role_text)) {}
  bool accepts(Component& target) const override { return dynamic_cast<Role*>(&target) != nullptr; }
  std::string roleText() const override { return role_text_; }
  Role* get() const {
    if (!target_) return nullptr;
    target_->ensureReady();
    return dynamic_cast<Role*>(target_);
  }

 private:
  std::string role_text_;
};

/// The same to several components.
template <class Role>
class LinkList : public Link<Role> {
 public:
  using Link<Role>::Link;
  bool takesMany() const override { return true; }
  void add(Component* target) override {
    if (targets_.empty()) this->set(target);
    targets_.push_back(target);
  }
  std::vector<Role*> all() const {
    std::vector<Role*> roles;
    for (Component* target : targets_) target->ensureReady(), roles.push_back(dynamic_cast<Role*>(target));
    return roles;
  }

 private:
  std::vector<Component*> targets_;
};

}  // namespace stroma

#include "framework/scene/node.h"  // completes Node and defines Component::find
