#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// A stretch of a contact's border along which the conductivity jumps from one value to another.
struct ContactArc {
  BorderPiece piece;
  double begin = 0;
  double end = 0;
  bool closed = false;  ///< a whole ellipse; else both ends are corners or junctions
  bool begins_at_sheet =
      false;  ///< the end lies on the sheet's border, where its mirror image joins
  bool ends_at_sheet = false;
  double left = 1;        ///< conductivity / background on the left of the direction of travel
  double right = 1;       ///< and on the right
  double grading = 3;     ///< of the points on it, see graded_parameter
  int contact = 0;        ///< whose border it is
  int left_contact = -1;  ///< which contact's conductivity `left` is, -1 the background
  int right_contact = -1;
};

/// The contacts that cover a point: the one whose ratio counts there, -1 where there is none.
int contact_at(const Scene& scene, std::complex<double> point);
double ratio_at(const Scene& scene, std::complex<double> point);

/// All stretches of border within the sheet at which the conductivity jumps: borders hidden in a
/// contact of lower ratio are left out, what several contacts share is there once. Exact up to
/// rounding for every scene, whatever overlaps or sticks out.
std::vector<ContactArc> contact_arcs(const Scene& scene, const Sheet& sheet);

/// Whether conductivities of this ratio differ so much, more than tenfold, that the equation takes
/// precautions which the usual contacts do without.
bool is_strong(double ratio);

/// Whether two arcs have an end in common.
bool are_joined(const ContactArc& a, const ContactArc& b);

/// Where a border ends, at a corner of its contact, at another border or at the sheet's, the
/// potential goes like r^lambda. With the exponent p of the grading (see graded_parameter) the
/// points' error falls as their number to the -p lambda: third order with the usual p = 3 as long
/// as lambda is about 1. Strong contacts have corners with lambda down to 1/2; their arcs get the p
/// that makes third order of it again.
void set_gradings(const Sheet& sheet, std::vector<ContactArc>& arcs);

/// The smallest positive lambda, at most 1, of two wedges side by side that fill a straight angle
/// on whose sides no current passes: conductivities `first` and `second`, and the first's angle.
double corner_exponent(double first, double second, double angle);

/// Quadrature points on the borders of the contacts, mapped onto the unit disc. A closed border has
/// points at equal parameters, which converge spectrally; a stretch between corners or junctions
/// has the midpoint rule in s with the parameter s^p / (s^p + (1 - s)^p) (Kress 1990), p the arc's
/// grading, whose points gather at the ends, where the density is singular. All arrays [points].
struct BorderPoints {
  Eigen::ArrayXd x, y;                ///< position
  Eigen::ArrayXd normal_x, normal_y;  ///< unit normal to the right of the direction of travel
  Eigen::ArrayXd curvature;           ///< counter-clockwise positive
  Eigen::ArrayXd weight;              ///< arc length that the point stands for
  Eigen::ArrayXd depth;               ///< 1 - |w|^2, 0 on the sheet's border
  std::vector<int> arc;               ///< to which each belongs
  std::vector<int> first;             ///< [arcs + 1] index of each arc's first point

  Eigen::Index size() const { return x.size(); }
};

/// `counts` [arcs]: points on each.
BorderPoints border_points(const Sheet& sheet, const std::vector<ContactArc>& arcs,
                           const std::vector<int>& counts);

/// The parameter of point `index` of `count` on an arc, and how fast it runs with s in [0, 1].
struct Graded {
  double parameter, speed;
};
Graded graded_parameter(const ContactArc& arc, int index, int count);

/// The arcs of a scene with the points that resolution 1 takes on each.
struct BorderLayout {
  std::vector<ContactArc> arcs;
  std::vector<int> counts;
};

/// As many points as what lies next to each border demands: other borders, the mirror image of the
/// border in the edge of the sheet, an electrode, its own far side. A border that comes very close
/// to something is cut there, so that points gather at that place and not all round.
/// `electrodes` [2, L] on the unit circle.
enum class BorderCuts { where_close, none };
BorderLayout border_layout(const Sheet& sheet, const Eigen::Array2Xd& electrodes,
                           const Scene& scene, BorderCuts cuts = BorderCuts::where_close);

}  // namespace ertbench
