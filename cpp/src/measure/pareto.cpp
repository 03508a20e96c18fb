#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "penumbra/error.h"
#include "penumbra/measure.h"

namespace penumbra {

std::vector<bool> pareto_front(std::span<const double> times_ms, std::span<const double> errors) {
    if (times_ms.size() != errors.size()) {
        throw Error{"Pareto front: " + std::to_string(times_ms.size()) + " times for " + std::to_string(errors.size()) +
                    " errors; give one of each per record"};
    }
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (std::isfinite(times_ms[i]) && std::isfinite(errors[i])) {
            order.push_back(i);
        }
    }
    std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
        return times_ms[a] != times_ms[b] ? times_ms[a] < times_ms[b] : errors[a] < errors[b];
    });

    // From fast to slow, a point stays if it has a smaller error than all before it, or equals the last that stayed.
    std::vector<bool> on_front(errors.size(), false);
    double best_error = std::numeric_limits<double>::infinity();
    double its_time_ms = 0.0;
    for (const std::size_t i : order) {
        const bool equal = errors[i] == best_error && times_ms[i] == its_time_ms;
        if (errors[i] < best_error || equal) {
            on_front[i] = true;
            best_error = errors[i];
            its_time_ms = times_ms[i];
        }
    }
    return on_front;
}

}  // namespace penumbra
