// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/contact_of_surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "framework/mechanics/mapping.h"
#include "framework/mesh/cell_lists.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma::collision {
namespace {

using Kind = CollisionModel::Kind;

/// The models of a state.
struct Body {
  State* state;
  bool is_moved;
  std::vector<const CollisionModel*> models{};
  bool has(Kind kind) const { return of(kind) != nullptr; }
  const CollisionModel* of(Kind kind) const {
    const auto at = std::ranges::find_if(models, [kind](const CollisionModel* model) { return model->kind() == kind; });
    return at == models.end() ? nullptr : *at;
  }
};

bool isBelowIntegrator(const State& state) {
  for (const Node* at = &state.node(); at; at = at->parent())
    for (const auto& component : at->components())
      if (dynamic_cast<const Integrator*>(component.get())) return true;
  return false;
}

/// An integrator moves a state below it, and what is mapped from such a state, also in another branch of the scene.
bool isMoved(const State& state, const std::vector<Mapping*>& mappings) {
  if (isBelowIntegrator(state)) return true;
  return std::ranges::any_of(mappings, [&](Mapping* mapping) {
    mapping->ensureReady();
    if (&mapping->output() != &state) return false;
    return std::ranges::any_of(mapping->inputs(), [&](const State* input) { return isMoved(*input, mappings); });
  });
}

class Description {
 public:
  Description(Component& contact, const Component& response, const Method* method)
      : contact_(contact), response_(response), method_(method) {}
  void run(const std::string& parameters) {
    collect();
    dropUnmet();
    std::ranges::stable_partition(bodies_, [](const Body& body) { return body.is_moved; });
    check();
    setParameters(parameters);
    setBodies();
    setPairs();
    setDistances();
    tellDifferences();
  }

 private:
  void collect();
  void dropUnmet();
  void check() const;
  void setParameters(const std::string& parameters);
  void setBodies();
  void setPairs();
  void setDistances();
  void tellDifferences() const;
  bool meet(const Body& a, const Body& b) const;
  double thicknessOf(const Body& body) const;
  void set(const char* attribute, const std::string& value, const std::string& from);
  void link(const char* attribute, Component& target);

  Component& contact_;
  const Component& response_;
  const Method* method_;
  std::vector<Body> bodies_;
};

void Description::collect() {
  std::vector<CollisionModel*> models;
  response_.node().root().collect(models);
  std::vector<Mapping*> mappings;
  response_.node().root().collect(mappings);
  for (CollisionModel* model : models) {
    model->ensureReady();
    if (!model->isActive()) continue;
    auto at = std::ranges::find_if(bodies_, [model](const Body& body) { return body.state == &model->state(); });
    if (at == bodies_.end()) bodies_.push_back({&model->state(), isMoved(model->state(), mappings)}), at = bodies_.end() - 1;
    at->models.push_back(model);
  }
}

/// All models of two bodies may meet, or none. A body meets itself where two of its models may.
bool Description::meet(const Body& a, const Body& b) const {
  const CollisionModel *one = nullptr, *other = nullptr;  // of a pair that does not meet
  bool any = false;
  for (const CollisionModel* of_a : a.models)
    for (const CollisionModel* of_b : b.models)
      if (CollisionModel::mayMeet(*of_a, *of_b))
        any = true;
      else
        one = of_a, other = of_b;
  if (any && one && a.state != b.state)
    throw ComponentError(fmt::format("{} and {} have no contact, but others of {} and {} do: a {} is of whole bodies", one->path(),
                                     other->path(), a.state->path(), b.state->path(), contact_.type()),
                         "the same group, simulated and selfCollision for all models of a body");
  return any;
}

void Description::dropUnmet() {
  std::vector<Body> met;
  for (const Body& body : bodies_)
    if (std::ranges::any_of(bodies_, [&](const Body& other) { return meet(body, other); })) met.push_back(body);
  if (met.empty() || std::ranges::none_of(met, &Body::is_moved))
    throw ComponentError(met.empty() ? "no two collision models of the scene may meet" : "no integrator moves a body that may meet another",
                         "models on two bodies, or selfCollision=\"true\"", "groups, simulated and active exclude contacts");
  bodies_ = std::move(met);
}

void Description::check() const {
  std::vector<Component*> all;
  response_.node().root().collect(all);
  for (const Component* other : all)
    if (other != &contact_ && other->type() == contact_.type())
      throw ComponentError(fmt::format("the scene has {} besides, and bodies would meet twice", other->path()),
                           fmt::format("one of both: response=\"{}\", or that component", contact_.type()));
  for (const Body& body : bodies_) {
    const CollisionModel& model = *body.models.front();
    if (body.state->hasFrames())
      throw ComponentError(fmt::format("{} is on {}, which has frames, and {} is one of points", model.path(), body.state->path(),
                                       contact_.type()),
                           "models on a state of points below it, which a RigidMapping carries");
    if (body.has(Kind::sphere) && body.models.size() > 1)
      throw ComponentError(fmt::format("{} has spheres and other models, and {} takes a body as its spheres or as its surface",
                                       body.state->path(), contact_.type()),
                           "one of both, or two states");
    for (const CollisionModel* each : body.models)
      if (!each->response().empty() && each->response() != contact_.type())
        throw ComponentError(fmt::format("{} has the contactResponse {}, and {} is the response of all", each->path(), each->response(),
                                         contact_.type()),
                             "no contactResponse, or a response for each pair that is not of whole surfaces");
  }
}

/// An attribute has one value.
void Description::set(const char* attribute, const std::string& value, const std::string& from) {
  Data* data = contact_.data().find(attribute);
  if (data->isSet())
    throw ComponentError(fmt::format("responseParams has {}, which follows from {}", attribute, from), "one of both");
  if (const auto problem = data->parse(value, DataOrigin::written)) throw ComponentError(problem->message, problem->expected);
}

void Description::link(const char* attribute, Component& target) {
  LinkBase* link = contact_.data().find(attribute)->link();
  link->add(&target);
  link->path += (link->path.empty() ? "@" : " @") + target.path();
}

/// "mu=0.3&stiffness=1e4"
void Description::setParameters(const std::string& parameters) {
  std::istringstream parts(parameters);
  for (std::string part; std::getline(parts, part, '&');) {
    const auto at = part.find('=');
    const std::string given = part.substr(0, at), name = given == "mu" ? "friction" : given;
    Data* data = contact_.data().find(name);
    const std::string expected = fmt::format("mu=NUMBER or ATTRIBUTE=VALUE of {}; several are joined by &", contact_.type());
    if (at == std::string::npos || !data || data->isOutput() || data->link())
      throw ComponentError(fmt::format("responseParams has \"{}\"", part), expected,
                           data ? std::string() : nearest(name, contact_.data().names()));
    if (data->isSet()) throw ComponentError(fmt::format("responseParams has {} twice", given), expected);
    set(name.c_str(), part.substr(at + 1), {});
  }
}

void Description::setBodies() {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    link(i == 0 ? "mstate" : "other", *body.state);
    const CollisionModel* surface = body.has(Kind::triangle) ? body.of(Kind::triangle) : body.of(Kind::line);
    const Topology *mesh = surface ? surface->topology() : nullptr, *own = topologyOf(*body.state);
    if (!mesh || mesh == own || (own && highestDimension(own->mesh()) == 3)) continue;  // the boundary of the cells
    if (i > 0)
      throw ComponentError(fmt::format("{} has the mesh {}, and {} that of {}{}", surface->path(), mesh->path(), contact_.type(),
                                       body.state->path(), own ? ", " + own->path() : ", which has none"),
                           "the mesh of the model in the node of the state");
    link("topology", *mesh->node().findByName(mesh->name()));
  }
}

void Description::setPairs() {
  bool self = false;
  std::string excluded;
  for (const Body& body : bodies_) self = self || meet(body, body);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    for (std::size_t j = i; j < bodies_.size(); ++j) {
      const bool is_of_still = !bodies_[i].is_moved && !bodies_[j].is_moved;
      if (!is_of_still && (i != j || self) && !meet(bodies_[i], bodies_[j])) excluded += fmt::format("{} {} ", i, j);
    }
  set("selfContact", self ? "true" : "false", "the models");
  if (!excluded.empty()) set("excludedPairs", excluded, "the models");
}

double Description::thicknessOf(const Body& body) const {
  for (const CollisionModel* model : body.models)
    if (model->contactDistance() != body.models.front()->contactDistance())
      throw ComponentError(fmt::format("{} and {} have two contactDistances, and a body of {} has one thickness",
                                       body.models.front()->path(), model->path(), contact_.type()),
                           "the same contactDistance for all models of a body");
  return body.models.front()->contactDistance();
}

void Description::setDistances() {
  const Data* distance = method_ ? method_->data().find("contactDistance") : nullptr;
  if (distance && distance->isSet() && method_->contactDistance() > 0) set("contactDistance", distance->print(), method_->path());
  std::vector<double> all;
  for (const Body& body : bodies_) all.push_back(thicknessOf(body));
  const auto [least, most] = std::ranges::minmax(all);
  if (most == 0) return;
  const char* from = "the contactDistance of the models";
  if (least == most) return set("thickness", fmt::format("{}", 2 * most), from);
  std::string text;
  for (const double each : all) text += fmt::format("{} ", each);
  set("radii", text, from);
}

void Description::tellDifferences() const {
  std::string without, more;
  const auto look = [&](const Component& component, std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (component.data().find(name)->isSet()) without += fmt::format("{}{}.{}", without.empty() ? "" : ", ", component.path(), name);
  };
  look(response_, {"explicitBetween", "toleratedError", "sofaLists", "treeDepth"});
  for (const Body& body : bodies_)
    for (const CollisionModel* model : body.models) look(*model, {"contactStiffness", "contactFriction", "contactRestitution"});
  if (!without.empty())
    response_.warn(fmt::format("{} has no use for {}. Its stiffness is a pressure, and all bodies have one friction "
                               "(responseParams=\"mu=...&stiffness=...\")",
                               contact_.type(), without));
  for (const Body& body : bodies_) {
    const CollisionModel& model = *body.models.front();
    if (body.has(Kind::sphere) || body.has(Kind::triangle) || !topologyOf(*body.state)) continue;
    const int dimension = highestDimension(topologyOf(*body.state)->mesh());
    if (dimension > (body.has(Kind::line) ? 1 : 0)) more += fmt::format("{}{}", more.empty() ? "" : ", ", model.path());
  }
  if (!more.empty())
    response_.inform(fmt::format("{} keeps the whole surface of a body apart from others, not only the lines and points of {}",
                                 contact_.type(), more));
  std::string switches;
  for (const char* name : {"usePointPoint", "useLinePoint", "useLineLine", "useSphereTriangle"})
    if (method_ && method_->data().find(name)->isSet()) switches += fmt::format("{}{}", switches.empty() ? "" : ", ", name);
  if (!switches.empty())
    response_.inform(fmt::format("{} of {} leave out no contact of a {}", switches, method_->path(), contact_.type()));
}

}  // namespace

bool isOfSurfaces(std::string_view response) {
  constexpr std::string_view all[] = {"BarrierContact", "ConstraintContact", "PenaltyContact"};
  return std::ranges::find(all, response) != std::end(all);
}

void describeContact(Component& contact, const Component& response, const Method* method, const std::string& parameters) {
  Description(contact, response, method).run(parameters);
}

}  // namespace stroma::collision
