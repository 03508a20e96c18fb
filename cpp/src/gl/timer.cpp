#include "gl/timer.h"

namespace penumbra {

Query StepClock::timestamp() {
    Query query;
    if (spare_.empty()) {
        query = Query::create(static_cast<GLenum>(GL_TIMESTAMP));
    } else {
        query = std::move(spare_.back());
        spare_.pop_back();
    }
    glQueryCounter(query.name(), GL_TIMESTAMP);
    return query;
}

void StepClock::begin(std::string_view name) {
    PENUMBRA_ASSERT(!open_);
    if (!enabled_) {
        return;
    }
    open_ = true;
    Measured& step = steps_.emplace_back();
    step.name = name;
    if (wall_clock_) {
        glFinish();  // what came before is not this step's
        step.started = std::chrono::steady_clock::now();
    } else {
        step.begin = timestamp();
    }
}

void StepClock::end() {
    if (!open_) {
        return;
    }
    open_ = false;
    Measured& step = steps_.back();
    if (wall_clock_) {
        glFinish();
        step.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - step.started).count();
    } else {
        step.end = timestamp();
    }
}

std::vector<StepTime> StepClock::collect() {
    PENUMBRA_ASSERT(!open_);
    std::vector<StepTime> times;
    times.reserve(steps_.size());
    for (Measured& step : steps_) {
        if (!wall_clock_) {
            GLuint64 begin_ns = 0;
            GLuint64 end_ns = 0;
            glGetQueryObjectui64v(step.begin.name(), GL_QUERY_RESULT, &begin_ns);
            glGetQueryObjectui64v(step.end.name(), GL_QUERY_RESULT, &end_ns);
            constexpr double kMsPerNs = 1e-6;
            step.ms = end_ns > begin_ns ? static_cast<double>(end_ns - begin_ns) * kMsPerNs : 0.0;
            spare_.push_back(std::move(step.begin));
            spare_.push_back(std::move(step.end));
        }
        times.push_back({std::move(step.name), step.ms});
    }
    steps_.clear();
    return times;
}

}  // namespace penumbra
