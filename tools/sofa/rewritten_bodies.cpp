// SPDX-License-Identifier: LGPL-2.1-or-later
// What SOFA's scenes leave to each body, and the engine wants of all that move together. In SOFA every body has a solver of its
// own and contacts tie them; here bodies that touch are one system, with one kind of solver. And in SOFA what no solver moves
// stays where it is, or where constraints and files put it, with all that is mapped from it; here something has to hold it.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <map>
#include <optional>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

constexpr std::array<const char*, 2> damping_names = {"rayleighStiffness", "rayleighMass"};
constexpr std::array<const char*, 2> damped_roles = {"force field", "mass"};
using Damping = std::array<double, 2>;

/// A component as far as a step depends on it.
struct Kind {
  std::string type;
  std::map<std::string, std::string> attributes;
  bool operator==(const Kind&) const = default;
};
/// What moves a body.
struct Solvers {
  Kind integrator, solver;
};

/// A number is one however it is written.
std::string plain(const std::string& text) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  return text.empty() || *end ? text : printReal(number);
}

Kind kindOf(const Element& element, bool with_damping) {
  static const std::vector<std::string_view> besides = {"name", "printLog", "listening", "tags", "verbose"};
  const auto has = [](const auto& list, std::string_view name) { return std::find(list.begin(), list.end(), name) != list.end(); };
  Kind kind{element.written->type, {}};
  for (const AttributeDescription& attribute : element.written->attributes) {
    const Data* data = element.probe->data().find(attribute.name);
    if (!data || data->link() || has(besides, attribute.name)) continue;
    if (with_damping || !has(damping_names, std::string_view(data->name())))
      kind.attributes[data->name()] = plain(std::string(trimmed(attribute.value)));
  }
  return kind;
}

Damping dampingOf(const Element& integrator) {
  Damping damping{};
  for (std::size_t i = 0; i < damping.size(); ++i) {
    const Data* data = integrator.probe->data().find(damping_names[i]);
    const std::string text = integrator.text(damping_names[i]);
    damping[i] = !text.empty() ? std::atof(text.c_str()) : data ? std::atof(data->print().c_str()) : 0;
  }
  return damping;
}

std::vector<Element*> allOf(const Place& place, std::string_view role) {
  std::vector<Element*> found;
  for (const auto& element : place.elements)
    if (!element->dropped && element->role() == role) found.push_back(element.get());
  return found;
}

bool isIn(const std::vector<Place*>& list, const Place* place) { return std::find(list.begin(), list.end(), place) != list.end(); }

bool isMoved(const Place& place) {
  for (const Place* above = &place; above; above = above->parent)
    if (above->has("integrator")) return true;
  return false;
}
bool moves(const Place& place) {
  return place.has("integrator") || std::any_of(place.children.begin(), place.children.end(),
                                                [](const auto& child) { return !child->dropped && moves(*child); });
}
bool isOfOneBody(const Place& place) { return allOf(place, "mechanical state").size() == 1 && !place.has("mapping"); }
/// It has a state of its own, from which another one is mapped.
bool leads(const Place& place) {
  if (!isOfOneBody(place)) return false;
  return std::any_of(place.children.begin(), place.children.end(),
                     [](const auto& child) { return !child->dropped && child->has("mapping") && child->has("mechanical state"); });
}

class Bodies {
 public:
  /// `isolated`: springs and penalties between bodies of several solvers are no part of a matrix.
  Bodies(SceneTree& tree, Diagnostics& diagnostics, bool isolated) : tree_(tree), diagnostics_(diagnostics), isolated_(isolated) {}

  void join() {
    bool any_moves = false;
    tree_.forEachPlace([&](Place& place) { any_moves = any_moves || place.has("integrator"); });
    const std::vector<const Place*> driven = drivenPlaces();
    tree_.forEachPlace([&](Place& place) {
      const bool is_driven = isOfOneBody(place) && std::find(driven.begin(), driven.end(), &place) != driven.end();
      const bool lies_in_held = place.parent && bodyAt(place.parent) && isOfOneBody(place);
      if (isMoved(place) || moves(place)) return;
      if (is_driven || lies_in_held || leads(place) || (any_moves && isTied(place))) still_.push_back(&place);
    });
    if (still_.empty() && !any_moves) return;
    const std::vector<Place*> meeting = bodiesThatMeet();
    const std::optional<Solvers> common = meeting.size() > 1 ? makeAlike(meeting) : std::nullopt;
    const Solvers usual{{"EulerImplicitSolver", {}}, {"SparseLDLSolver", {}}};
    for (Place* place : still_) hold(*place, common && isIn(meeting, bodyAt(place)) ? *common : usual);
  }

 private:
  /// The outermost node that moves, or holds, what is in a place; null: nothing does.
  Place* bodyAt(Place* place) const {
    Place* body = nullptr;
    for (; place; place = place->parent)
      if (place->has("integrator") || isIn(still_, place)) body = place;
    return body;
  }
  /// Where the states are that a component puts somewhere, which SOFA does at the end of a step whether a solver is there or not.
  std::vector<const Place*> drivenPlaces() const {
    std::vector<const Place*> driven;
    tree_.forEach([&](Element& element) {
      if (element.dropped || !putsNodes(element)) return;
      const std::string link = element.text("mstate");
      const LinkTarget target = link.empty() ? LinkTarget{} : tree_.follow(element, link, false);
      const Element* state = target.element ? target.element : element.place->nearest("mechanical state");
      driven.push_back(target.place ? target.place : state ? state->place : nullptr);
    });
    return driven;
  }
  /// It has a state of its own that something between two objects names.
  bool isTied(const Place& place) const {
    const std::vector<Element*> states = allOf(place, "mechanical state");
    bool is_named = false;
    if (!isOfOneBody(place)) return false;
    tree_.forEach([&](Element& element) {
      if (!isAnyOf(element.role(), {"force field", "position constraint", "projective constraint", "Lagrangian constraint"}))
        return;
      for (const char* name : {"object1", "object2"}) {
        if (!element.find(name)) continue;
        const LinkTarget target = tree_.follow(element, element.text(name), false);
        is_named = is_named || target.element == states[0] || (!target.element && target.place == &place);
      }
    });
    return is_named;
  }
  /// The bodies that something between two objects, or a mapping of several states, has to do with.
  std::vector<Place*> bodiesAt(const Element& element) const {
    std::vector<Place*> bodies;
    const auto add = [&bodies](Place* body) {
      if (body && !isIn(bodies, body)) bodies.push_back(body);
    };
    const std::string role = element.role();
    if (role.empty() || role == "engine" || role == "mesh engine" || role == "selection") return bodies;
    if (!element.find("object1") != !element.find("object2")) add(bodyAt(element.place));
    for (const char* name : {"object1", "object2", "input", "input1", "input2"})
      if (const AttributeDescription* given = element.find(name))
        forLinks(*given, [&](std::string_view link) {
          const LinkTarget target = tree_.follow(element, link, false);
          add(bodyAt(target.element ? target.element->place : target.place));
        });
    return bodies;
  }

  /// Those that may touch others, and those that something between two objects ties.
  std::vector<Place*> bodiesThatMeet() const {
    std::vector<Place*> meeting;
    const auto add = [&meeting](Place* body) {
      if (body && !isIn(meeting, body)) meeting.push_back(body);
    };
    bool answers = false;
    tree_.forEach([&answers](Element& element) { answers = answers || element.is("CollisionResponse"); });
    tree_.forEach([&](Element& element) {
      if (answers && element.role() == "collision model") add(bodyAt(element.place));
      if (const std::vector<Place*> tied = bodiesAt(element); tied.size() > 1) std::for_each(tied.begin(), tied.end(), add);
    });
    return meeting;
  }

  /// Nothing but contacts and springs that are no part of the matrix has to do with several of them.
  bool areApart() const {
    bool apart = isolated_, groups = false, pushes = false;
    tree_.forEachPlace([&groups](Place& place) {  // accepted, and no part any more
      for (const auto& each : place.elements)
        groups = groups || each->is("CollisionGroup") || each->written->type.ends_with("GroupManager");
    });
    tree_.forEach([&pushes](Element& each) {
      pushes = pushes ||
               (each.is("CollisionResponse") && isAnyOf(each.text("response"), {"", "default", "PenalityContactForceField"}));
    });
    if (groups && pushes) return false;  // bodies that touch have one solver
    tree_.forEach([&](Element& element) {
      const bool has_part = !element.probe || !element.probe->data().find("explicitForce") || element.place->nearest("integrator");
      if (has_part && !element.is("CollisionResponse") && bodiesAt(element).size() > 1) apart = false;
    });
    return apart;
  }

  /// SOFA's solver of each body iterates by itself: so do those of the system that they are here.
  bool keepConjugateGradients(const std::vector<Place*>& moved) {
    if (!allOf(*moved[0], "linear solver")[0]->is("CGLinearSolver") || !areApart()) return false;
    std::string paths;
    for (Place* body : moved) {
      if (!body->parent) return false;
      SceneTree::linkTo(*body->firstOf("integrator"));  // nodes have names from now on, without blanks
      paths += (paths.empty() ? "" : " ") + body->path();
    }
    for (Place* body : moved) allOf(*body, "linear solver")[0]->set("bodies", paths);
    return true;
  }

  /// The integrator and the linear solver that all of them have from now on, or the first of them if they are not alike: what is held
  /// gets them too. None: nothing of them moves.
  std::optional<Solvers> makeAlike(const std::vector<Place*>& meeting) {
    std::vector<Place*> moved;
    std::copy_if(meeting.begin(), meeting.end(), std::back_inserter(moved),
                 [](const Place* body) { return body->has("integrator"); });
    if (moved.empty()) return std::nullopt;
    Kind integrator = kindOf(*moved[0]->firstOf("integrator"), false);
    const std::vector<Element*> first = allOf(*moved[0], "linear solver");
    Damping shared = dampingOf(*moved[0]->firstOf("integrator"));
    bool same_kind = true, same_damping = true, same_solver = true;
    for (const Place* body : moved) {
      const Element& own = *body->firstOf("integrator");
      const std::vector<Element*> solvers = allOf(*body, "linear solver");
      same_kind = same_kind && kindOf(own, false) == integrator && !solvers.empty();
      same_damping = same_damping && dampingOf(own) == shared;
      same_solver = same_solver && same_kind && solvers.size() == 1 && kindOf(*solvers[0], true) == kindOf(*first[0], true);
    }
    if (!same_kind) {  // the first one moves all of them, which the engine tells
      for (Place* body : moved)
        if (!same_damping) handDown(*body);
      return Solvers{kindOf(*moved[0]->firstOf("integrator"), same_damping), first.empty() ? Kind{} : kindOf(*first[0], true)};
    }
    if (!same_damping) shared = {};
    for (std::size_t i = 0; i < shared.size(); ++i)
      if (moved[0]->firstOf("integrator")->probe->data().find(damping_names[i]))
        integrator.attributes[damping_names[i]] = printReal(shared[i]);
    const bool keeps = same_solver && moved.size() > 1 && keepConjugateGradients(moved);
    for (Place* body : moved)
      if (keeps && !same_damping) handDown(*body);
    if (keeps || (same_damping && same_solver)) return Solvers{integrator, kindOf(*first[0], true)};
    for (Place* body : moved) {
      if (!same_damping) handDown(*body);
      giveDirectSolver(*body);
    }
    return Solvers{integrator, {"SparseLDLSolver", {}}};
  }

  /// Of all bodies together: the iterations that were enough for one may not be.
  void giveDirectSolver(Place& body) {
    const std::vector<Element*> solvers = allOf(body, "linear solver");
    Element& kept = *solvers[0];
    for (Element* other : solvers) other->dropped = other != &kept;
    Element& integrator = *body.firstOf("integrator");
    if (integrator.find("linearSolver")) integrator.set("linearSolver", SceneTree::linkTo(kept));
    if (solvers.size() == 1 && kindOf(kept, true) == Kind{"SparseLDLSolver", {}}) return;
    diagnostics_.note(kept.written->where, kept.path(),
                      "bodies that touch or are tied are one system here: their solvers are made alike, direct ones");
    std::erase_if(kept.written->attributes, [](const AttributeDescription& attribute) { return attribute.name != "name"; });
    tree_.retype(kept, "SparseLDLSolver");
  }

  /// The damping of an integrator becomes that of the force fields and masses that it moves.
  void handDown(Place& body) {
    Element& integrator = *body.firstOf("integrator");
    const Damping damping = dampingOf(integrator);
    for (std::size_t i = 0; i < damping.size(); ++i) {
      if (integrator.probe->data().find(damping_names[i])) integrator.set(damping_names[i], "0");
      if (damping[i] != 0) addDamping(body, i, damping[i]);
    }
  }
  static void addDamping(Place& place, std::size_t which, double damping) {
    for (const auto& element : place.elements) {
      if (element->dropped || element->role() != damped_roles[which] || !element->probe->data().find(damping_names[which]))
        continue;
      element->set(damping_names[which], printReal(dampingOf(*element)[which] + damping));
    }
    for (const auto& child : place.children)
      if (!child->dropped) addDamping(*child, which, damping);
  }

  void hold(Place& place, const Solvers& solvers) {
    diagnostics_.note(place.node->where, place.path(),
                      "no integrator moves it: it is held where it is, or where the scene puts it");
    if (bodyAt(&place) == &place) add(place, solvers.integrator), addIfAny(place, solvers.solver);
    // what moved nodes does not go on with them after its end
    add(place, {"FixedProjectiveConstraint", {{"fixAll", "true"}, {"activate_projectVelocity", "true"}}});
  }
  void addIfAny(Place& place, const Kind& solver) {
    if (!solver.type.empty()) add(place, solver);
  }
  void add(Place& place, const Kind& kind) {
    const SourceLocation& where = place.node->where;
    ComponentDescription component{kind.type, {{"name", "held_by_the_scene_" + kind.type, where}}, where, place.node->folder};
    for (const auto& [name, value] : kind.attributes) component.attributes.push_back({name, value, where});
    tree_.add(place, std::move(component));
  }

  SceneTree& tree_;
  Diagnostics& diagnostics_;
  bool isolated_;
  std::vector<Place*> still_;  ///< that no integrator moves, and that others follow or something puts
};

}  // namespace

/// Cells beside a state that a mapping places: SOFA counts the nodes that they name, and the mapping says where these are.
void Rewriting::countNodes(Element& container, Element& state) {
  double last = -1;
  for (const char* name : {"edges", "lines", "triangles", "quads", "tetrahedra", "tetras", "hexahedra", "hexas"})
    for (const double node : writtenNumbers(container.text(name))) last = std::max(last, node);
  if (last < 0) return;
  if (!container.find("nbPoints")) container.set("nbPoints", std::to_string(long(last) + 1));
  state.set("useTopology", "false");
}

/// A link to the state beside it, which a mapping places: the state has no nodes yet that it could give.
static bool dropLinkToPlaced(Element& container, const Element* state, const SceneTree& tree) {
  if (!state || !container.place->has("mapping")) return false;
  for (const char* name : {"position", "rest_position", "size", "src", "filename", "topology"})
    if (state->find(name)) return false;
  for (const char* name : {"position", "points"})
    if (container.find(name) && tree.follow(container, container.text(name), true).element == state)
      return container.remove(name), true;
  return false;
}

/// Cells whose nodes are those of the state, which has them from a loader or from another mesh: a container of SOFA needs no
/// positions.
void Rewriting::takeNodesOfNeighbour(Element& container) {
  const std::string& type = container.written->type;
  if (type != "MeshTopology" && !type.ends_with("SetTopologyContainer")) return;
  Element* state = container.place->firstOf("mechanical state");
  const bool is_placed = dropLinkToPlaced(container, state, *tree_);
  if (hasOwnNodes(container)) return;
  bool has_cells = false;
  for (const char* name : {"edges", "lines", "triangles", "quads", "tetrahedra", "tetras", "hexahedra", "hexas"})
    has_cells = has_cells || container.find(name);
  const bool is_of_points = state && (!state->find("template") || state->text("template").starts_with("Vec3"));
  if (has_cells && is_placed) return countNodes(container, *state);
  if (!has_cells || !is_of_points) return;
  for (const char* name : {"position", "rest_position", "src"}) {
    if (!state->find(name)) continue;
    const std::string link = state->text(name);
    const Element* source = tree_->follow(*state, link, std::string_view(name) != "src").element;
    if (!link.starts_with("@") || !source || source == &container || !source->probe || !source->probe->data().find("position")) return;
    return container.set("position", std::string_view(name) == "src" ? link + ".position" : link);
  }
  if (container.place->has("mapping") && !state->find("topology")) return countNodes(container, *state);
  Element* mesh = state->find("topology") ? tree_->follow(*state, state->text("topology"), false).element : nullptr;
  for (const auto& each : container.place->elements)
    if (!mesh && !each->dropped && each->role() == "topology" && each.get() != &container && hasOwnNodes(*each)) mesh = each.get();
  if (mesh && mesh != &container) container.set("position", SceneTree::linkTo(*mesh) + ".position");
}

bool putsNodes(const Element& element) {
  return isAnyOf(element.written->type, {"ReadState", "LinearMovementProjectiveConstraint", "PartialLinearMovementProjectiveConstraint",
                                         "LinearVelocityProjectiveConstraint", "OscillatorProjectiveConstraint",
                                         "AffineMovementProjectiveConstraint", "PatchTestMovementProjectiveConstraint",
                                         "ParabolicProjectiveConstraint", "HermiteSplineProjectiveConstraint"});
}

void Rewriting::joinBodies() {
  findOwnDamping();  // before that of integrators becomes that of what they move
  Bodies(*tree_, diagnostics_, quirks_.isOn("isolated-springs")).join();
}

}  // namespace stroma::sofa
