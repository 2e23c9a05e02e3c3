#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/contacts/contact_fit.h"

namespace ertbench {

/// Images of fitted contacts.
class ContactImage {
 public:
  explicit ContactImage(const Sensor& sensor);

  /// `image` [pixels] S/m: by the covered area of each pixel, exactly.
  void most_likely(std::span<const EllipticContact> contacts,
                   Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// The mean over the posterior (Laplace's approximation of it, and the two best numbers of
  /// contacts by their evidence): the image of least expected squared error. Its covered areas are
  /// good to some per cent of a pixel, which the mean evens out.
  void posterior_mean(const ContactFit::Found& found, Eigen::Ref<Eigen::RowVectorXd> image) const;

 private:
  void add_mean(const ContactFit::Result& result, double weight,
                Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// Adds `weight` times the change of these contacts, in units of the background.
  void add_sample(std::span<const EllipticContact> contacts, double weight,
                  Eigen::Ref<Eigen::RowVectorXd> image) const;

  PixelGrid pixels_;
  double background_ = 0;
  Eigen::MatrixXd samples_;  ///< [parameters of the most contacts, samples] standard normal
};

}  // namespace ertbench
