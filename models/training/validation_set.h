#pragma once

#include <torch/types.h>

#include "models/networks/network.h"
#include "models/training/standardisation.h"

namespace ertbench {

class DatasetFile;

/// The validation frames that hold a contact, with the noise that the file gives them.
class ValidationSet {
 public:
  /// Throws InputError where no frame holds a contact.
  ValidationSet(const DatasetFile& file, const Standardisation& standardisation);

  struct Score {
    double error = 0;   ///< mean over the frames of |image - truth| / |truth|, conductivity changes
    double spread = 0;  ///< largest difference of a pixel between two frames' images
  };

  /// Puts the network into evaluation mode.
  Score score(Network& network) const;

 private:
  torch::Tensor frames_;
  torch::Tensor truths_;
  torch::Tensor mask_;  ///< see sheet_mask
};

}  // namespace ertbench
