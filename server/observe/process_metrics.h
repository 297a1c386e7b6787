// Metrics of this process, under the names that every Prometheus client library gives them.
#pragma once

#include <string>
#include <vector>

#include <prometheus/metric_family.h>

namespace burnish {

/// A metric of one value, without labels.
prometheus::MetricFamily single_metric(std::string name, std::string help, prometheus::MetricType type,
                                       double value);

/// Memory, CPU time, file descriptors and start time, read from /proc now. Thread-safe.
std::vector<prometheus::MetricFamily> process_metrics();

}  // namespace burnish
