// SPDX-License-Identifier: LGPL-2.1-or-later
// The elastic force fields of meshes: attributes, material, checks and fields, whatever the kind of element.
#pragma once
#include "components/elasticity/elastic_elements.h"
#include "framework/algebra/volume_terms.h"
#include "framework/fem/element_kernels_field.h"
#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/turns_stresses.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// One class serves every elastic component name: a name sets its default words, the mesh decides the kind of element.
class ElasticForceField : public ElementKernelsField, public OpenChoices, public TurnsStresses, public ResistsVolumes {
 public:
  /// The words of `method`: first those of ElasticMethod, then other components' words for the same.
  enum class Word : int {
    small,
    large,
    polar,
    svd,
    nodal,
    green,
    qr,
    none,
    polar2,
    triangle,
    hexahedron,
    stable_polar,
    identity,
    green_lagrange
  };

  // ---- set by the registration of a name ----
  std::vector<ElasticKind> kinds;  ///< that it serves
  Word method_word = Word::large;
  bool only_small = false;  ///< a name that stands for method small

  void declare(DataTable& table) override;
  void init() override;
  void recompile() override;
  ForceTraits traits() const override;
  void compile() override;
  bool useExactTangent(bool exact) override;
  bool keepTurning(bool on) override;
  void addTurning(double part) override;
  long patternRevision() const override { return tangent_changes_; }
  std::string choice() const override;

  void addVolumeTerms(VolumeTerms& terms) const override;
  Cost cost() const override;
  std::string worstElement(ConstRows x) const override;
  std::string doubt(ConstRows x) const override;
  std::vector<std::string> cellFields() const override;
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override;
  CellFieldShape cellFieldShape(const std::string& name) const override;

 private:
  enum class Tangent : int { warped, exact };
  enum class Assembling : int { automatic, yes, no };
  enum class Dilatation : int { automatic, local, mean };

  /// The kind of element that the mesh has and the name serves; throws ComponentError when none or several fit.
  void chooseKind(const Topology& topology);
  /// Throws ComponentError for combinations of attributes that mean nothing together.
  void checkVariant() const;
  void checkMeanDilatation() const;
  /// Throws ComponentError for what does not go with incompatible modes.
  void checkIncompatibleModes() const;
  /// Those of the kind, with what this field chooses before their bind().
  std::unique_ptr<ElasticElements> newElements() const;
  /// Of automatic: by Poisson's ratio, where the method has a mean. True when it is another than before.
  bool chooseDilatation();
  /// What depends on the material alone.
  void compileMaterial();
  std::string whyNoMean() const;
  /// Notes on what is so by construction and surprises nevertheless.
  void tellSurprises() const;
  /// Throws ComponentError for lists of a wrong length or a value without a material.
  void readMaterial();
  /// Of one cell [Pa], localStiffnessFactor included.
  Lame lame(std::size_t cell) const { return LameOf(constants_)(cell); }
  std::unique_ptr<ElementKernels> makeMethod(const ElasticElements& elements) const;
  void addVolumesOfHexahedra(VolumeTerms& terms) const;
  void addVolumesOfNodes(VolumeTerms& terms) const;
  /// The rows of this state out of the system's.
  ConstRows ownRows(ConstRows x) const;
  // ---- of cells; x starts at node 0 ----
  /// Cauchy's stress, the mean over the cell [Pa]; `change` is the volume change of its pressure, or NaN: that of each point.
  Mat3 stress(std::size_t cell, ConstRows x, double change) const;
  /// The volume change that each cell's pressure comes from where dilatation is mean, else empty.
  std::vector<double> meanChanges(ConstRows x) const;
  bool isSet(const char* attribute) const { return data().find(attribute)->isSet(); }

  TopologyLink topology_;
  std::string template_;
  std::vector<double> young_modulus_{5000}, poisson_ratio_{0.45}, stiffness_factor_;
  bool update_b_ = false, update_volume_ = false, first_for_others_ = false;
  Tangent tangent_ = Tangent::warped;
  Assembling assembling_ = Assembling::automatic;
  Dilatation dilatation_ = Dilatation::automatic;
  PolarOf polar_of_ = PolarOf::gradient;
  bool reduced_ = false, incompatible_ = false;
  double plastic_max_threshold_ = 0;

  /// Of the topology, which owns it.
  const Mesh* mesh_ = nullptr;
  ElasticVariant variant_;
  std::vector<Lame> constants_;  ///< [Pa], one for all or one per cell
  Index first_row_ = -1;         ///< that method_ was made for
  std::string kind_word_;        ///< "tetrahedron", for messages
  /// The cells as one kind of element: makes the method, and evaluates fields for output.
  std::unique_ptr<ElasticElements> elements_;
  /// Those of the other tangent, which useExactTangent() has put aside; null before.
  std::unique_ptr<ElementKernels> other_method_;
  std::unique_ptr<ElasticElements> other_elements_;
  std::unique_ptr<ElasticElements> (*make_elements_)() = nullptr;
  long tangent_changes_ = 0;
};

}  // namespace stroma
