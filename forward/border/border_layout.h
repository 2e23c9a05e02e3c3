#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// An arc of a contact's border across which the conductivity jumps.
struct ContactArc {
  BorderPiece piece;
  double begin = 0;
  double end = 0;
  bool closed = false;           ///< a whole ellipse; else both ends are corners or junctions
  bool begins_at_sheet = false;  ///< on the sheet's border, where the mirror image joins
  bool ends_at_sheet = false;
  double left = 1;        ///< conductivity / background on the left of the direction of travel
  double right = 1;       ///< conductivity / background on the right
  double grading = 3;     ///< exponent of graded_parameter
  int contact = 0;        ///< index of the contact
  int left_contact = -1;  ///< contact whose conductivity `left` is, -1 for the background
  int right_contact = -1;
};

/// The contact whose conductivity counts at a point; -1 without a contact.
int contact_at(const Scene& scene, std::complex<double> point);
double ratio_at(const Scene& scene, std::complex<double> point);

/// All arcs within the sheet across which the conductivity jumps. Borders hidden in a contact of
/// lower ratio are left out, shared borders occur once. Exact up to rounding for every scene,
/// including contacts that overlap or extend beyond the sheet.
std::vector<ContactArc> contact_arcs(const Scene& scene, const Sheet& sheet);

/// True if this ratio is above 10 or below 1/10, for which the equation takes extra precautions.
bool is_strong(double ratio);

/// True if two arcs have an end in common.
bool are_joined(const ContactArc& a, const ContactArc& b);

/// Sets the gradings of the arcs. Where a border ends (at a corner, another border or the sheet's),
/// the potential behaves like r^lambda. With the exponent p of the grading (graded_parameter) the
/// error falls with the number of points to the power -p lambda: third order with the usual p = 3
/// if lambda is about 1. Strong contacts have corners with lambda down to 1/2; the p of their arcs
/// restores third order.
void set_gradings(const Sheet& sheet, std::vector<ContactArc>& arcs);

/// Smallest positive lambda, at most 1, of two adjacent wedges that fill a straight angle with
/// insulated sides: conductivities `first` and `second`, and the angle of the first, rad.
double corner_exponent(double first, double second, double angle);

/// Quadrature points on the borders of the contacts, mapped onto the unit disc. A closed border has
/// points at equal parameters, which converge spectrally. An arc between corners or junctions has
/// the midpoint rule in s with the parameter s^p / (s^p + (1 - s)^p) (Kress 1990), where p is the
/// arc's grading; its points gather at the ends, where the density is singular. All arrays
/// [points].
struct BorderPoints {
  Eigen::ArrayXd x, y;                ///< position
  Eigen::ArrayXd normal_x, normal_y;  ///< unit normal to the right of the direction of travel
  Eigen::ArrayXd curvature;           ///< counter-clockwise positive
  Eigen::ArrayXd weight;              ///< quadrature weight, an arc length
  Eigen::ArrayXd depth;               ///< 1 - |w|^2, 0 on the sheet's border
  std::vector<int> arc;               ///< index of each point's arc
  std::vector<int> first;             ///< [arcs + 1] index of each arc's first point

  Eigen::Index size() const { return x.size(); }
};

/// `counts` [arcs]: points on each.
BorderPoints border_points(const Sheet& sheet, const std::vector<ContactArc>& arcs,
                           const std::vector<int>& counts);

/// Parameter of point `index` of `count` on an arc, and its derivative with respect to s in [0, 1].
struct Graded {
  double parameter, speed;
};
Graded graded_parameter(const ContactArc& arc, int index, int count);

/// The arcs of a scene, with the number of points on each at resolution 1.
struct BorderLayout {
  std::vector<ContactArc> arcs;
  std::vector<int> counts;
};

/// Numbers of points by the distance from each border to its neighbours: other borders, its mirror
/// image in the edge of the sheet, electrodes, its own far side. A border that comes very close to
/// a neighbour is cut there, so that points gather at that position only. `electrodes` [2, L] on
/// the unit circle.
enum class BorderCuts { where_close, none };
BorderLayout border_layout(const Sheet& sheet, const Eigen::Array2Xd& electrodes,
                           const Scene& scene, BorderCuts cuts = BorderCuts::where_close);

}  // namespace ertbench
