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
  /// Validates the parameters and prepares everything that is constant during steps. Called once, when all linked sources
  /// are ready. Components returned by find...() or a Link are initialised first, so the order in the file does not
  /// matter. Throws ComponentError.
  virtual void init() {}
  /// Discards the data of past steps (a history, a warm start): the simulation returns to its initial state and must
  /// repeat bit for bit. Not needed by a component whose steps depend only on x, v and the time.
  virtual void reset() {}
  /// Writes or reads, under names, all data of past steps that later steps depend on besides x, v and the time: the data
  /// that reset() discards. After reading, a run continues with the same bits as one that never stopped.
  /// Archive::isReading() gives the direction. Throws std::runtime_error if the values read belong to another scene.
  virtual void serialize(Archive&) {}
  /// Called when an attribute declared recompiled() has a new value in a running scene: validates it and recomputes what
  /// init() derived from attributes. Compiled roles (force fields, masses) are compiled again afterwards, and the data of
  /// serialize() is kept. Throws ComponentError. After any exception the old value is restored and this is called again.
  virtual void recompile() { init(); }
  /// The attribute `template` as written, before any other attribute is read: for a component whose attribute types
  /// depend on it (Data::keepIn).
  virtual void chooseTemplate(const std::string&) {}
  /// False if another component of the node replaces this one: searches by role then skip it. Called before init().
  virtual bool answersLookup() const { return true; }
  /// The type of a component that this one requires and that its node lacks: it is then created in the node with its
  /// defaults. Empty: nothing is missing. Called when all components of the node have read their attributes.
  virtual std::string missingPartner() const { return {}; }
  /// The role in words, for messages: "force field".
  virtual std::string roleText() const = 0;

  const std::string& type() const { return type_; }
  const std::string& name() const { return name_; }
  const SourceLocation& where() const { return where_; }
  bool isMadeForAnother() const { return is_made_for_another_; }  ///< created by missingPartner(), not in the scene
  std::string path() const;  ///< "/liver/fem"
  Node& node() const { return *node_; }
  DataTable& data() { return data_; }
  const DataTable& data() const { return data_; }

  /// Runs init() unless it has already run; used by look-ups. Throws DependencyFailed if it failed before, and
  /// ComponentError with the chain of components for a circular dependency.
  void ensureReady();
  bool isReady() const { return stage_ == Stage::ready; }
  bool hasFailed() const { return stage_ == Stage::failed; }
  void markFailed() { stage_ = Stage::failed; }

  /// The component with role `Role` in this node, otherwise (upwards = true) in the nearest ancestor that has one; null if
  /// there is none. Throws ComponentError if a node has several. The result is initialised.
  template <class Role>
  Role* find(bool upwards = false) const;

  /// A warning or a note raised while initialising, shown with this component's location and path.
  void warn(std::string message, std::string suggestion = {}) const;
  void inform(std::string message) const;

 protected:
  /// For components that a program adds to a running scene: sets the name, and the node of `other`, which does not own
  /// it.
  void standBeside(const Component& other, std::string name);

 private:
  friend class Factory;
  friend class Node;
  friend class Instantiation;
  friend class LiveEdit;
  enum class Stage { created, initialising, ready, failed };

  /// `folder_`: the base of this component's relative file names.
  std::string type_, name_, folder_;
  SourceLocation where_;
  Node* node_ = nullptr;
  Diagnostics* diagnostics_ = nullptr;
  Stage stage_ = Stage::created;
  bool is_made_for_another_ = false;
  DataTable data_;
  /// An attribute of this component that takes the value of another component's attribute.
  struct DataLink {
    Data* target;
    Component* source;
    const Data* from;
    SourceLocation where;
    bool by_src;  ///< created by `src`: copied only if the source has a value
  };
  /// Before init(): copies the values of linked attributes, whose components are then ready.
  void copyLinkedValues();
  void reportFailure(const std::string& message, const std::string& expected, const std::string& suggestion) const;

  /// Not owning: source components live as long as the tree.
  std::vector<DataLink> data_links_;
};

/// Thrown if a component needs another one whose failure has already been reported: prints no further message.
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
