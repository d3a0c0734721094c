// SPDX-License-Identifier: LGPL-2.1-or-later
// The rewriting of one scene, in passes over its tree: what has no effect leaves, what acts where SOFA looks for nothing
// leaves, links are followed as SOFA follows them, values and attributes become those that components here have.
#pragma once
#include <map>
#include <set>

#include "tools/sofa/quirks.h"
#include "tools/sofa/scene_tree.h"

namespace stroma::sofa {

class Rewriting {
 public:
  Rewriting(SceneDescription& scene, Factory& factory, Modules& modules, Diagnostics& diagnostics,
            std::vector<std::string>& no_effect);
  void run();

 private:
  // ---- rewriting.cpp: the tree ----
  void readSwitches();
  void rewriteNode(Place& place);
  void acceptTypes();
  void keepOneIntegrator(Place& place, bool is_moved);
  void dropIdle(Place& place, bool is_moved);
  bool isMapped(const Element& state) const;
  bool isPulledFromElsewhere(const Element& state, std::string_view role) const;
  void dropVisualMappings();
  void dropUnusedSolvers();
  void dropUnusedLoaders();
  void dropIdleWatch();
  bool movesElsewhere(const Element& element) const;

  // ---- rewritten_parts.cpp: what becomes another part, and what nobody asks ----
  void renameType(Element& element);
  void splitMass(Element& field);
  void fillParts(Element& field);
  void meanVoxels(Element& field);  // rewritten_masses.cpp
  void makeChains();                // rewritten_shapes.cpp
  void meanThinCells(Element& field);
  void meanJoint(Element& joint);   // rewritten_shapes.cpp
  void findNodesOfRegions();        // rewritten_shapes.cpp
  void emptyRegion(Element& region);
  void meanEmbedding(Element& mapping);  // rewritten_shapes.cpp
  void splitPlasticity(Element& field);
  void divideSteps();
  void chooseSolvers();
  Element* preconditionerOf(Element& solver);
  void addFactors(Element& preconditioner, const Element& solver);
  void dropIdleEngines();
  void dropVoids();
  void dampVelocities();
  void resolveAliases();
  void expandPrefabs();  // rewritten_prefabs.cpp
  void expandSolids();   // rewritten_solids.cpp
  void dropUnheard();
  void dropIdleMappings();
  bool hasOnlyFollowers(const Place& place) const;
  bool isAskedFromOutside(const Place& place) const;
  static void moveJoints(NodeDescription& node);

  // ---- rewritten_bodies.cpp: what SOFA leaves to each body ----
  void joinBodies();
  void findOwnDamping();

  // ---- rewritten_planes.cpp: bodies in a plane ----
  void liftPlanes();
  void widen(Element& element, bool has_frames);
  void widenVectors(Element& element, bool has_frames);
  const Element* leaderOf(const Element& state) const;

  // ---- rewritten_links.cpp ----
  void rewriteLinks(Element& element);
  void rewriteLink(Element& element, AttributeDescription& attribute, std::vector<std::string>& broken);
  std::string componentLink(Element& element, const Data& data, const std::string& text);
  std::string dataLink(Element& element, const AttributeDescription& attribute);
  void warnOfMoving(const Element& element, const AttributeDescription& attribute, const Element& source, const std::string& data);
  Element* meant(const Element& asker, const LinkTarget& target, const LinkBase& wanted) const;
  void listParts(Element& mesh, const std::string& list);
  void listPartsOfRegion(const Element& region, const std::string& data);
  void renumberPart(Element& region);

  // ---- rewritten_attributes.cpp ----
  void rewriteAttributes(Element& element);
  bool keepsAttribute(Element& element, AttributeDescription& attribute);
  void readList(const Element& element, const Data& data, AttributeDescription& attribute, const std::string& text);
  bool keepsValue(Element& element, Data& data, AttributeDescription& attribute);
  bool keepsUnknown(Element& element, const AttributeDescription& attribute);
  void tellUnread(const Element& element);
  void rewriteTemplate(Element& element);
  void checkTemplate(const Element& element, const std::string& text);

  // ---- rewritten_components.cpp: what a type means in SOFA ----
  void applyMeaning(Element& element);
  /// Sets the attribute that stands for a quirk, unless that is switched off.
  void setQuirk(Element& element, std::string_view quirk, const std::string& attribute, const std::string& value);
  void meanSelection(Element& element);
  void meanField(Element& element);
  void meanSpringsOfMesh(Element& springs);
  void meanPrisms(Element& element);
  // ---- rewritten_fields.cpp ----
  void meanOfNames(Element& element);
  void meanStressFields(Element& element);
  void meanSprings(Element& element);
  bool haveMass(const Element& springs) const;
  void meanMembrane(Element& element);
  void meanDirections(Element& field);
  void meanRestShape(Element& springs);
  void meanLoads(Element& element);
  void tellSpringsOfFrames(Element& element);
  bool mayLoadQuads(const Element& load) const;
  void meanConstantForce(Element& load);
  void meanPlane(Element& plane);
  void meanLayer(Element& load);
  void meanStress(Element& load);
  void includeLast(Element& element);
  void checkOneBody(Element& field);
  void warnOfTangents(const Element& field);
  void warnOfFrames(const Element& mapping);
  void warnOfChance(const Element& engine);
  void holdArms(Element& mapping);
  void meanCarried(Element& mapping);
  bool actsOnNothing(Element& element);
  bool holdsNothing(Element& element);
  void sayWhyIdle(const Element& element);
  void sayWhyTetrahedraDoNotTouch(const Element& model);
  void checkSequence(Element& loader);
  // ---- rewritten_components.cpp again ----
  void meanMesh(Element& element);
  // ---- rewritten_states.cpp ----
  void meanState(Element& element);
  void leaveOnePosition(Element& state);
  void evenLists(Element& state);
  void takeNumbersOfMesh(Element& state);
  // ---- rewritten_constraints.cpp ----
  void meanConstraint(Element& element);
  void meanMatrix(Element& element, const Element& integrator);
  void meanForceOfConstraint(const Element& constraint);
  bool findsForcesOfConstraint(const Element& asker);
  void meanSkeleton(Element& constraint);
  void addSweeps();
  const Element* findConstraintSolver(bool has_loop);
  void warnOfTolerance(const Element* solver, const Element& loop);
  bool areForcesSwept();
  void meanPairs(Element& pairs, bool is_assembled);
  void meanSlidingPlane(Element& plane, bool is_assembled);
  bool isAssembled(const Element& integrator) const;
  bool isOfFrames(const Element& constraint) const;
  // ---- rewritten_components.cpp again ----
  Element* meshOf(const Element& element) const;
  void cutHexahedra(Element& field);
  bool takesWholeTangent(const Element& solver) const;
  void completeGrid(Element& grid);
  void leaveOtherCells(Element& container);
  bool hasOwnNodes(const Element& mesh) const;
  void takeNodesOfNeighbour(Element& container);
  static void countNodes(Element& container, Element& state);  // rewritten_bodies.cpp
  void joinCorners(Element& mesh);
  void readMeshFiles(Element& element);
  void readMeshFile(Element& element, const std::string& attribute);
  // ---- rewritten_files.cpp ----
  void readOwnFile(Element& element);
  void addFoldersOfTree();
  void tellMissingFile(const Element& loader);
  void readSurfaces(Element& grid);
  void takeOfFile(Element& element, const std::string& numbers);
  void replaceByFile(Element& element, const std::string& attribute, const std::string& numbers);

  // ---- rewritten_masses.cpp ----
  void meanMass(Element& element);
  void meanLists(Element& mass);
  void leaveOutInertia();
  void addToOthers(Element& mass);
  void warnOfWeight(const Element& mass, const Element& state);
  void shareMass(Element& mass, const Element& state);
  void holdMassless(Place& place, bool is_moved);
  bool movesNodes() const;
  bool hasMass(const Place& place) const;
  bool actsIn(const Place& place, const std::set<std::string>& roles) const;
  bool isPulledThroughOthers(const Element& state) const;

  // ---- rewritten_searches.cpp ----
  void meanSearch(Element& solver);
  static Element* searchOf(const Element& integrator);

  // ---- rewritten_solvers.cpp ----
  void meanSolver(Element& element);
  bool hasForcesOfConstraint() const;
  bool hasActuators() const;
  void meanCorrection(Element& correction);
  void meanActuator(Element& element);
  void meanVariational(Element& element);
  void meanStatics(Element& solver);
  void meanNewton(Element& newton);
  void meanMultiStep(Element& solver);
  void warnOfAccepted(const Element& element);
  void warnOfIgnored(const Element& element);
  void takeFriction(Element& response);
  void listContacts(Element& response, const Element* method);
  bool areContactsInOrder();
  static void fillVariables(Element& response);
  void meanRules(Element& response, const std::string& mu);
  std::string answerHere(const Element& element, const std::string& attribute, const std::string& word, const std::string& mu);
  bool isIdleSwitch(std::string_view name, const Element& system) const;

  // ---- rewritten_times.cpp ----
  double timeStep() const;
  void meanPulse(Element& pressure);
  void takeExternalForces();
  void matchShapes();  // rewritten_planes.cpp
  void meanTimes(Element& element);
  void shareMovement(Element& constraint);
  void holdOtherAxes(Element& flow);
  void warnOfTurns(const Element& movement);

  /// Unless the scene writes it.
  void setDefault(Element& element, const std::string& attribute, const std::string& value);
  void noEffect(const std::string& what);
  void warn(const SourceLocation& where, const Element& element, const std::string& what, std::string message,
            std::string suggestion = {});

  SceneDescription& scene_;
  Factory& factory_;
  Modules& modules_;
  Diagnostics& diagnostics_;
  std::vector<std::string>& no_effect_;
  bool is_foreign_ = false;
  Quirks quirks_;
  std::map<const Element*, ComponentDescription> plasticity_;  ///< by the field whose stress it lowers
  std::map<const Element*, std::pair<std::string, std::string>> own_damping_;  ///< integrators of what damps itself, their own factors
  std::map<const Element*, std::string> layers_;               ///< by the load whose triangles lie in a box
  std::string turn_tolerance_;                                 ///< of frames that are tied
  bool has_solids_ = false;  ///< capsules or boxes, which are surfaces here
  std::set<const Element*> blind_;                             ///< regions that find no nodes in SOFA
  std::vector<Element*> parts_;                                ///< regions whose cells count their own nodes
  std::unique_ptr<SceneTree> tree_;
};

/// It puts nodes somewhere at times. (rewritten_bodies.cpp)
bool putsNodes(const Element& element);
/// Its indices are node 0 in SOFA where none are written, and no node where they are written and empty. (rewritten_constraints.cpp)
bool holdsFirstNode(const std::string& type);
/// The loader of a file of meshes by its ending, or empty.
std::string_view loaderOf(std::string_view file);
/// The numbers of a list that is written out; of a link none.
std::vector<double> writtenNumbers(const std::string& text);
std::string printed(const std::vector<double>& numbers);
void scaleForces(Element& load);
void nameCoefficients(Element& damping, bool of_frames);
/// Three numbers as SOFA's stream reads them: those at the start of the text, zero where a word is no number, and then the others.
std::string readByStream(const std::string& text, const std::string& others);

// ---- attribute_table.cpp: what SOFA declares ----

/// Types that a scene in the dialect may hold besides those that any scene may: without effect on numbers.
bool isAcceptedType(std::string_view type);
/// Components of SOFA that only make values of others: without effect where nobody reads these.
bool isEngineOfSofa(std::string_view type);
/// Components that turn contacts into forces or constraints.
bool isContactAnswer(std::string_view type);
/// SOFA's present name of what is called otherwise here, or the type itself.
std::string_view typeHere(std::string_view type);
/// Attributes of SOFA without effect on numbers, of all types ("*") or of one.
bool hasNoEffect(std::string_view type, std::string_view attribute);
/// Attributes that SOFA's component reads and the one here does not: ignoring them would change the result.
bool isReadBySofa(std::string_view type, std::string_view attribute);
/// Whether the value of such an attribute is that without it.
bool isSofasDefault(std::string_view attribute, std::string_view value);

}  // namespace stroma::sofa
