// jobs/campaign/shared_compute.cpp: each loop as units of a campaign, whose keys are the number of the loop and of the
// unit.
#include "jobs/campaign/campaign.hpp"

#include <algorithm>
#include <map>

#include "drover/base/error.hpp"
#include "files/bytes.hpp"

namespace drover::jobs {

namespace {
constexpr std::size_t few_items = 8;         ///< which every process computes for itself, without a word to the others
constexpr std::size_t numbers_of_unit = 16;  ///< at least, of items of one number

std::string key_of(std::size_t loop, std::size_t unit) { return text("loop-{}-unit-{}", loop, unit); }

class SharedLoops {
public:
    explicit SharedLoops(CampaignOptions options) {
        options.shares_wait = true;  // the next loop needs all numbers of this one
        if (options.job.collect)
            for (const UnitRecord& record : campaign_records(options.job.folder, options.identity)) take(record);
        else campaign_ = std::make_unique<Campaign>(plan(), std::move(options));
    }

    /// As ComputeAll.
    std::vector<double> compute(std::size_t items, std::size_t width, const NumbersOf& numbers) {
        loop_ = {.number = loop_.number + 1,
                 .items = items,
                 .width = width,
                 .of_unit = std::max<std::size_t>(numbers_of_unit / std::max<std::size_t>(width, 1), 1),
                 .numbers = &numbers};
        if (items * width <= few_items) {
            loop_.of_unit = items;
            return loop_.compute_unit(0);
        }
        if (campaign_ && campaign_->run().stopped) throw Interrupted{};
        std::vector<double> found;
        for (std::size_t unit = 0; unit < loop_.units(); ++unit) {
            const std::string key = key_of(loop_.number, unit);
            const auto there = known_.find(key);
            if (const auto why = failed_.find(key); why != failed_.end()) throw Error(Fault::run, {}, why->second);
            if (there == known_.end()) throw Interrupted{};
            found.insert(found.end(), there->second.begin(), there->second.end());
            known_.erase(there);
        }
        if (found.size() != items * width)
            fail_environment("records of a loop hold {} numbers in place of {}; remove the folder of the shares",
                             found.size(), items * width);
        return found;
    }

private:
    /// The present loop.
    struct Loop {
        std::size_t number = 0, items = 0, width = 0, of_unit = 1;
        const NumbersOf* numbers = nullptr;

        std::size_t units() const { return (items + of_unit - 1) / of_unit; }
        std::vector<double> compute_unit(std::size_t unit) const {
            const std::size_t begin = unit * of_unit, end = std::min(begin + of_unit, items);
            std::vector<double> found((end - begin) * width);
            for (std::size_t item = begin; item < end; ++item)
                (*numbers)(item, std::span(found).subspan((item - begin) * width, width));
            return found;
        }
    };

    UnitPlan plan() {
        return {.wanted =
                    [this](const Offer& offer) {
                        for (std::size_t unit = 0; unit < loop_.units(); ++unit)
                            if (!known_.contains(key_of(loop_.number, unit)) && !offer(key_of(loop_.number, unit)))
                                return;
                    },
                .run = [this](const std::string& key) { return run(key); },
                .take = [this](const UnitRecord& record) { take(record); }};
    }

    UnitResult run(const std::string& key) const {
        files::ByteWriter to;
        to(loop_.compute_unit(std::stoul(key.substr(key.rfind('-') + 1))));
        return {.content = files::text_of(to.bytes)};
    }

    void take(const UnitRecord& record) {
        if (record.state == UnitState::done) {
            files::ByteReader reader{std::as_bytes(std::span(record.result.content))};
            reader(known_[record.key]);
            failed_.erase(record.key);
        } else if (!known_.contains(record.key)) {
            failed_[record.key] = record.reason;
        }
    }

    Loop loop_ = {};
    std::map<std::string, std::vector<double>> known_;  ///< of this and of later loops
    std::map<std::string, std::string> failed_;         ///< why, by key
    std::unique_ptr<Campaign> campaign_ = {};           ///< none: it only collects
};
}  // namespace

ComputeAll shared_compute(CampaignOptions options) {
    return [loops = std::make_shared<SharedLoops>(std::move(options))](std::size_t items, std::size_t width,
                                                                       const NumbersOf& numbers) {
        return loops->compute(items, width, numbers);
    };
}

}  // namespace drover::jobs
