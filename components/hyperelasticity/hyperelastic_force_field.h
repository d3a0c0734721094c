// SPDX-License-Identifier: LGPL-2.1-or-later
// The hyperelastic force fields of meshes: law, parameters, fibres, checks and cell fields, whatever the kind of cell.
#pragma once
#include <map>

#include "components/hyperelasticity/viscous_law.h"
#include "framework/algebra/volume_terms.h"
#include "framework/fem/element_kernels_field.h"
#include "framework/mechanics/history.h"
#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"

namespace stroma {

class HyperelasticForceField : public ElementKernelsField, public History, public OpenChoices, public ResistsVolumes {
 public:
  enum class Discretization : int { mjed, standard };
  enum class Dilatation : int { automatic, local, mean };

  // ---- set by the registration of a name ----
  const CellKind* kind = &cell_kinds::tetrahedron;
  Discretization discretization = Discretization::mjed;

  void declare(DataTable& table) override;
  void init() override;
  void recompile() override;
  ForceTraits traits() const override;
  void compile() override;
  std::string choice() const override;
  bool useDefiniteTangent(bool definite) override;
  void reset() override;
  void serialize(Archive& archive) override;
  void setTime(double t) override;
  void stepEnded(double t) override;
  const std::vector<double>& history() const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addForceAndProduct(ConstRows x, ConstRows v, ConstRows dx, double factor, Rows f) override;

  void addVolumeTerms(VolumeTerms& terms) const override;
  Cost cost() const override;
  std::string worstElement(ConstRows x) const override;
  std::vector<std::string> cellFields() const override;
  void cellField(const std::string& name, ConstRows x, std::vector<double>& out) const override;
  CellFieldShape cellFieldShape(const std::string& name) const override;

  const hyperelastic::HyperelasticLaw& law() const { return law_; }
  const Mesh& mesh() const { return *mesh_; }
  hyperelastic::Values parameters(std::size_t cell) const { return parametersIn(values_, cell); }

 protected:
  /// What the kernels are built on.
  hyperelastic::Cells cells() const;

  // ---- for a name that has its kind of cell or its law from elsewhere ----
  void declareMesh(DataTable& table);
  void declareMethod(DataTable& table);
  /// mesh_, which holds cells of `kind`.
  virtual void chooseMesh();
  /// law_, and parameter_set_ unless attributes give parameters by name.
  virtual void chooseLaw();

  TopologyLink topology_;
  std::string template_;
  const Mesh* mesh_ = nullptr;
  hyperelastic::HyperelasticLaw law_;  ///< as chosen, with its number of terms
  std::vector<double> parameter_set_;

 private:
  /// What there is for a kind of cell; null: nothing.
  struct KindKernels {
    std::unique_ptr<ElementKernels> (*make)(const hyperelastic::HyperelasticLaw&, const hyperelastic::Cells&);
    std::unique_ptr<ElementKernels> (*mean_volume)(const hyperelastic::Cells&, const hyperelastic::HyperelasticLaw&,
                                                    bool definite);
    decltype(hyperelastic::ResidualStressKernels::tetrahedra) held;
    double product, assembly;
  };
  KindKernels kernels() const;
  void declareLaw(DataTable& table);
  void declareParameters(DataTable& table);
  void refusePlugin() const;
  hyperelastic::HyperelasticLaw withTerms(const hyperelastic::HyperelasticLaw& law) const;
  std::vector<std::string> givenNames() const;
  void readParameters();
  void fillNamed(std::size_t set, std::vector<double>& values) const;
  void checkModuli(const Lame& lame, hyperelastic::Values values) const;
  struct DirectionCount {
    enum class Place { all, cell, node } place;
    std::size_t each;  ///< 1 (fibre), 2 (and sheet) or 3 (and normal)
  };
  DirectionCount countDirections();
  void readDirections();
  Mat3 axes(std::size_t cell) const;
  std::size_t cellCount() const;
  std::span<const Index> nodesOf(std::size_t cell) const;
  std::vector<Vec3> restCorners(std::size_t cell) const;
  std::string describe(std::size_t cell) const;
  /// Columns of F at the cell's integration points; x starts at node 0.
  std::vector<Mat3> deformations(std::size_t cell, ConstRows x) const;
  Mat3 stress(std::size_t cell, std::size_t point, const Mat3& f) const;
  Mat3 meanStrain(std::size_t cell, ConstRows x) const;
  Mat3 meanStress(std::size_t cell, ConstRows x) const;
  double volumeRatio(std::size_t cell, const std::vector<Mat3>& points) const;
  double smallestJacobian(std::size_t cell, ConstRows x) const;
  ConstRows ownRows(ConstRows x) const;
  std::size_t worstCell(ConstRows x, double& jacobian) const;
  void checkFinite(ConstRows x, ConstRows f);
  void checkShapes() const;
  double largestPoissonRatio() const;  ///< at small strains
  /// Of automatic: by Poisson's ratio at rest, where the law and the cells have a mean.
  void chooseDilatation();
  /// Throws ComponentError where there is no mean dilatation.
  void checkMeanDilatation() const;
  void checkViscousPart() const;
  hyperelastic::Values parametersIn(const std::vector<double>& values, std::size_t cell) const;
  /// The part k U(J) of the energy is apart from the rest: it has the mean dilatation, or does not relax.
  bool volumeIsApart() const {
    return mean_dilatation_ || (series_.terms() > 0 && series_.part == PronyPart::deviatoric);
  }
  std::vector<double> withoutVolume() const;
  hyperelastic::Cells elasticCells() const;
  std::unique_ptr<ElementKernels> makeElastic() const;
  void makeViscous(const hyperelastic::Cells& cells, std::unique_ptr<ElementKernels> whole);
  ConstRows systemRows() const;

  std::string material_name_ = "ArrudaBoyce";
  std::vector<double> young_modulus_, poisson_ratio_;
  std::map<std::string, std::vector<double>> named_;
  std::vector<Vec3> directions_;
  bool regularised_ = false, projected_ = false, consider_inversion_ = false;
  Dilatation dilatation_ = Dilatation::automatic;
  bool mean_dilatation_ = false;  ///< dilatation_, or what was chosen for it
  bool definite_ = false;         ///< useDefiniteTangent()
  /// What method_ was made for beside numbers.
  struct Made {
    Index first_row;
    bool mean_dilatation;
    std::size_t parameters;  ///< of the law
    bool operator==(const Made&) const = default;
  } made_{};
  std::string stiff_in_volume_;
  std::unique_ptr<ElementKernels> other_method_;  ///< the method with the other tangent, once it was asked for
  std::string parameter_file_;
  PronyAttributes prony_;

  std::vector<double> values_;                   ///< parameters, of one cell for all or of each
  std::vector<double> local_values_;             ///< the same with k = 0, where volumeIsApart()
  std::vector<Mat3> axes_;                       ///< one for all or one per cell
  PronySeries series_;                           ///< without terms: the law is elastic
  hyperelastic::ViscousLaw* viscous_ = nullptr;  ///< method_, where it is viscous
  std::string fault_;                            ///< why the last force was not finite
};

}  // namespace stroma
