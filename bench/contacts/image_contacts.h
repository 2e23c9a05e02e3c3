#pragma once

#include <Eigen/Core>
#include <vector>

#include "bench/contacts/contact_rule.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Reads contacts out of images, a few microseconds each; what it needs for that it keeps from
/// image to image. Not thread-safe.
///
/// The pixels on the sheet whose |δσ| reaches the rule's limits fall into regions that hang
/// together by edges and are of one sign. A region with several maxima is divided between those
/// that the rule calls separate, each pixel going the way of its steepest ascent (a watershed): two
/// fingers whose blobs touch are two contacts. A contact's place is the centroid weighted by |δσ|.
class ContactReader {
 public:
  explicit ContactReader(const Sensor& sensor);

  /// `change` [pixels] S/m, all finite. The contacts, the strongest first, take the place of what
  /// `contacts` held.
  void read(const ContactRule& rule, const Eigen::Ref<const Eigen::RowVectorXd>& change,
            std::vector<FoundContact>& contacts);

 private:
  /// A maximum and the pixels that lead up to it.
  struct Hill {
    int parent = 0;  ///< the hill it became part of; itself where it is one of its own
    double peak = 0;
    double weight = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    int pixels = 0;
  };

  struct Pixel {
    double height = 0;  ///< |δσ|
    int index = 0;
    /// Of two that are equally high the first.
    bool operator<(const Pixel& other) const {
      return height > other.height || (height == other.height && index < other.index);
    }
  };

  int hill_of(int pixel);
  /// The hill whose flank the pixel is on; a new one where it is a maximum. Other hills that it
  /// touches become one with that where the pixel is no saddle.
  int climb(const Pixel& pixel, const double* change, double saddle);
  int unite(int a, int b);

  double background_;
  PixelGrid pixels_;
  std::vector<Eigen::Vector2d> centres_;  ///< [pixels]
  std::vector<Pixel> order_;              ///< those above the limit, the highest first
  std::vector<int> hill_;                 ///< [pixels]; none before the pixel was climbed
  std::vector<Hill> hills_;
};

/// The contacts of one image, the strongest first.
std::vector<FoundContact> contacts_of_image(const Sensor& sensor, const ContactRule& rule,
                                            const Eigen::Ref<const Eigen::RowVectorXd>& change);

}  // namespace ertbench
