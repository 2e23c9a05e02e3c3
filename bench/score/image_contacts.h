#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// What counts as a contact in an image of changes of the conductivity, δσ.
struct ContactRule {
  /// Of the image's largest |δσ| (D.1): pixels with less belong to no contact.
  double threshold = 0.25;
  /// The least |δσ| over the background that counts at all; an image without it shows no contact.
  double floor = 0;
  /// Two maxima are two contacts where the way between them goes lower than this part of the lower
  /// one; else they are one.
  double saddle = 0.7;
  int least_pixels = 1;  ///< of a contact

  bool operator==(const ContactRule&) const = default;
};

/// How far apart contacts may be, mm.
struct ContactDistances {
  double match = 20;  ///< of a found contact from a true one that it is
  double ospa = 50;   ///< cut-off of the OSPA distance
};

/// "contacts" of an experiment: how contacts are read out of images and held against the true ones.
struct ContactSettings {
  std::optional<double> threshold;  ///< of ContactRule; nothing: chosen on the validation set
  std::optional<double> floor;      ///< the same
  /// The test set on which they are chosen in place of the validation set: one that no result is
  /// told of, and whose contacts and noise are like those of the others.
  std::string chosen_on;
  double saddle = ContactRule{}.saddle;
  std::optional<double> match_mm;  ///< nothing: a tenth of the sheet's longest side
  std::optional<double> ospa_mm;   ///< nothing: a quarter of it

  /// The rule where nothing is chosen: what is not given is ContactRule's default.
  ContactRule rule() const;
  ContactDistances distances(const Sensor& sensor) const;

  bool operator==(const ContactSettings&) const = default;
};

/// `{"threshold", "floor", "saddle", "match_mm", "ospa_mm", "chosen_on"}`; "auto" where nothing is
/// given.
nlohmann::json to_json(const ContactSettings& settings);

}  // namespace ertbench

/// Sums over the pixels of an image of changes [pixels], S/m; C4 and D.1 are numbers in the
/// supplement of the DD-ERT paper (Zheng et al.).
namespace ertbench {

/// Of the background; an image that nowhere exceeds it is empty: far above the rounding of the
/// voltages, far below any contact.
inline constexpr double kEmptyImage = 1e-9;
/// Keeps a pixel that is exactly on a threshold in, whatever the rounding of its value.
inline constexpr double kThresholdSlack = 1e-9;

/// Whether no |change| is above kEmptyImage of the background.
bool is_empty(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// Whether positive and negative parts are equal to a thousandth: |sum| <= 1e-3 sum|.|. Such
/// weights have no centroid.
bool cancels(const Eigen::Ref<const Eigen::RowVectorXd>& weights);

/// `change` with everything under `fraction` of its largest absolute value set to zero (D.1).
Eigen::RowVectorXd thresholded(const Eigen::Ref<const Eigen::RowVectorXd>& change, double fraction);

/// Centroid of the pixel centres weighted by `change` (C4), domain units; nothing where the weights
/// cancel.
std::optional<Eigen::Vector2d> centroid(const Sensor& sensor,
                                        const Eigen::Ref<const Eigen::RowVectorXd>& change);

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

/// One contact as it is kept, in mm from the origin of the domain units.
struct ContactReading {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double strength = 0;  ///< integral of |δσ| over the contact, S/m mm²
  double peak = 0;      ///< largest |δσ|, S/m
  double area_mm2 = 0;

  bool operator==(const ContactReading&) const = default;
};

/// What was read out of one image. A frame without a usable image has no contacts and no values.
struct FrameReading {
  std::vector<ContactReading> contacts;          ///< the strongest first
  std::optional<double> peak;                    ///< the δσ of the largest |δσ|, S/m
  std::optional<double> sum;                     ///< of δσ over the sheet, S/m mm²
  std::optional<Eigen::Vector2d> centroid_mm;    ///< of the whole image (C4), where it has one
  std::optional<Eigen::Vector2d> centroid25_mm;  ///< after the threshold of 25 % (D.1)

  /// Share of the norm of the voltages' change that the image explains, 0 ... 1 (ExplainedChange).
  std::optional<double> explained;

  bool operator==(const FrameReading&) const = default;
};

/// `change` [pixels] S/m, all finite.
FrameReading frame_reading(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           std::span<const FoundContact> contacts);

/// Centroids of the scene's contacts that lie on the sheet, mm from the origin of the domain units.
std::vector<Eigen::Vector2d> true_places_mm(const Sensor& sensor, const Scene& scene);

/// Of contacts that were found, in the same unit.
std::vector<Eigen::Vector2d> places_mm(const Sensor& sensor, std::span<const FoundContact> found);

}  // namespace ertbench
