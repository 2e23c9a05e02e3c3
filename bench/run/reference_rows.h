#pragma once

#include <span>
#include <vector>

#include "bench/contacts/contact_settings.h"
#include "bench/record/cache.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// The rows that need no solver: the true images themselves, scored like any other, and the image
/// of an untouched sheet. Contacts are read out of both by the rule that holds where none is chosen
/// (ContactSettings::rule).
std::vector<ResultRow> reference_rows(const Sensor& sensor, std::span<const DatasetSpec> tests,
                                      const ContactSettings& contacts, const Cache& cache);

}  // namespace ertbench
