// Self-checking bench of a machine with a program, in C++ for Verilator.
//
// It plays a host that knows nothing but the manifest: it carries out the
// commands of host.hex through one window of the machine after another (the
// machine's own host bus, Avalon-MM, AXI4-Lite), with gaps and back-pressure
// where a bus has them. While a program runs, every result of every operation
// is compared with the one the cycle-accurate simulator has computed
// (results.hex), in the cycle and on the element where it belongs
// (places.hex).
//
//     robovec_bench [bus] [avalon] [axi4lite]      all three without arguments
//
// One line per window says PASS or FAIL; the exit code is 0 only if all pass.

#include "Vrobovec_bench_top.h"
#include "bench_config.h"
#include "verilated.h"

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace {

// Mistakes that are told one by one.
constexpr int most_told = 10;

enum class Kind { end, write, read, start, wait };

struct Command {
    Kind kind;
    uint32_t note, address, data;
};

struct Place {
    uint32_t element, cycle;
};

// Bits of a port, however wide Verilator made it.
uint64_t bits(uint64_t port, unsigned low, unsigned width) {
    return port >> low & (width == 64 ? ~0ull : (1ull << width) - 1);
}

template <std::size_t Words>
uint64_t bits(const VlWide<Words>& port, unsigned low, unsigned width) {
    uint64_t found = 0;
    for (unsigned bit = 0; bit < width;) {
        const unsigned from = low + bit;
        found |= static_cast<uint64_t>(port[from / 32] >> from % 32) << bit;
        bit += 32 - from % 32;
    }
    return bits(found, 0, width);
}

[[noreturn]] void give_up(const std::string& why) {
    std::printf("FAIL: %s\n", why.c_str());
    std::exit(2);
}

std::vector<std::string> lines(const char* name) {
    std::ifstream file(name);
    if (!file) give_up(std::string("cannot read ") + name);
    std::vector<std::string> found;
    for (std::string line; std::getline(file, line);) found.push_back(line);
    return found;
}

uint64_t hexadecimal(const std::string& text, std::size_t from, std::size_t digits) {
    return std::strtoull(text.substr(from, digits).c_str(), nullptr, 16);
}

struct Expected {
    std::vector<Command> commands;
    std::vector<Place> places;
    std::vector<uint64_t> results;

    Expected() {
        for (const std::string& line : lines("host.hex"))
            commands.push_back({static_cast<Kind>(hexadecimal(line, 0, 2)),
                                static_cast<uint32_t>(hexadecimal(line, 2, 6)),
                                static_cast<uint32_t>(hexadecimal(line, 8, 8)),
                                static_cast<uint32_t>(hexadecimal(line, 16, 8))});
        for (const std::string& line : lines("places.hex"))
            places.push_back({static_cast<uint32_t>(hexadecimal(line, 0, 8)),
                              static_cast<uint32_t>(hexadecimal(line, 8, 8))});
        for (const std::string& line : lines("results.hex"))
            results.push_back(hexadecimal(line, 0, 16));
        // The files end with a line that stands for nothing.
        if (places.size() != ROBOVEC_OPERATIONS + 1u || commands.empty()
            || results.size() != ROBOVEC_OPERATIONS * static_cast<std::size_t>(ROBOVEC_RUNS) + 1)
            give_up("the files of the bench do not fit together");
    }
};

class Bench {
public:
    Bench(const Expected& expected, int window)
        : expected(expected), window(window), top(new Vrobovec_bench_top(&context)) {
        top->window = static_cast<uint8_t>(window);
        top->avs_byteenable = 15;
        top->axi_wstrb = 15;
        top->reset = 1;
        for (int i = 0; i < 8; ++i) tick();
        top->reset = 0;
        for (int i = 0; i < 4; ++i) tick();
    }

    // Carries out all commands; whether everything was as expected.
    bool run() {
        for (const Command& command : expected.commands) {
            switch (command.kind) {
            case Kind::end: return report();
            case Kind::write: write(command.address, command.data); break;
            case Kind::read: read_back(command); break;
            case Kind::start:
                ++run_number;
                place = 0;
                next_cycle = 0;
                in_run = true;
                write(command.address, command.data);
                break;
            case Kind::wait: wait(command); break;
            default: give_up("host.hex holds an unknown command");
            }
        }
        give_up("host.hex has no end");
    }

private:
    const Expected& expected;
    const int window;
    VerilatedContext context;
    std::unique_ptr<Vrobovec_bench_top> top;
    uint64_t clocks = 0, compared = 0, words_read = 0, mistakes = 0;
    uint64_t run_number = ~0ull;
    std::size_t place = 0;
    uint32_t next_cycle = 0;
    bool in_run = false;
    uint32_t dice = 20251;

    bool is_told() { return ++mistakes <= most_told; }

    void tell_line(const char* file, std::size_t number) {
        const std::vector<std::string> all = lines(file);
        std::printf("  %s\n", number < all.size() ? all[number].c_str() : "(unknown)");
    }

    // ---- Clocks.

    // Lets the inputs take effect; what the outputs then say is what a
    // register would take at the next edge.
    void settle() { top->eval(); }

    void tick() {
        top->clock = 0;
        settle();
        watch();
        top->clock = 1;
        top->eval();
        if (++clocks > ROBOVEC_MOST_CLOCKS)
            give_up("no end after " + std::to_string(clocks) + " clocks");
    }

    // Results, each in its cycle.
    void watch() {
        if (!top->results_running) return;
        const uint32_t cycle = top->results_cycle;
        if ((!in_run || cycle != next_cycle) && is_told())
            std::printf("run %" PRIu64 ": the machine is in cycle %u instead of %" PRId64 "\n",
                        run_number, cycle, in_run ? static_cast<int64_t>(next_cycle) : -1);
        next_cycle = cycle + 1;
        for (; place < ROBOVEC_OPERATIONS && expected.places[place].cycle < next_cycle; ++place) {
            const Place& due = expected.places[place];
            const uint64_t wanted = expected.results[run_number * ROBOVEC_OPERATIONS + place];
            const uint64_t found = bits(top->results, due.element * ROBOVEC_WIDTH, ROBOVEC_WIDTH);
            ++compared;
            if ((due.cycle != cycle || found != wanted) && is_told()) {
                std::printf("run %" PRIu64 ", cycle %u: result %0*" PRIx64 " instead of %0*" PRIx64
                            ":\n", run_number, cycle, (ROBOVEC_WIDTH + 3) / 4, found,
                            (ROBOVEC_WIDTH + 3) / 4, wanted);
                tell_line("operations.txt", place);
            }
        }
    }

    // ---- The windows.

    // Xorshift (Marsaglia, 2003), for gaps.
    uint32_t roll() {
        dice ^= dice << 13;
        dice ^= dice >> 17;
        return dice ^= dice << 5;
    }

    // One access in sixteen has gaps of up to seven clocks in it.
    bool is_slow = false;
    void gap() {
        is_slow = (roll() >> 8 & 15) == 0;
        if (is_slow)
            for (uint32_t i = dice & 7; i > 0; --i) tick();
    }
    bool goes() { return !is_slow || (roll() >> 8 & 3) == 0; }

    void complain(uint32_t address, const char* what) {
        if (is_told())
            std::printf("clock %" PRIu64 ", address %x: %s\n", clocks, address, what);
    }

    void write(uint32_t address, uint32_t data) {
        gap();
        switch (window) {
        case 1:
            top->avs_address = address;
            top->avs_writedata = data;
            top->avs_write = 1;
            for (bool waits = true; waits; tick()) {
                settle();
                waits = top->avs_waitrequest;
            }
            top->avs_write = 0;
            break;
        case 2: write_axi(address, data); break;
        default:
            top->bus_address = address;
            top->bus_writedata = data;
            top->bus_write = 1;
            tick();
            top->bus_write = 0;
        }
    }

    // Address and data are offered on their own, and the response is taken
    // when it suits.
    void write_axi(uint32_t address, uint32_t data) {
        bool address_left = true, data_left = true, response_left = true;
        top->axi_awaddr = static_cast<uint64_t>(address) << 2;
        top->axi_wdata = data;
        while (address_left || data_left || response_left) {
            if (address_left && !top->axi_awvalid) top->axi_awvalid = goes();
            if (data_left && !top->axi_wvalid) top->axi_wvalid = goes();
            top->axi_bready = goes();
            settle();
            const bool address_taken = top->axi_awvalid && top->axi_awready;
            const bool data_taken = top->axi_wvalid && top->axi_wready;
            if (top->axi_bvalid && top->axi_bready) {
                if (address_left || data_left) complain(address, "a response before its write");
                if (top->axi_bresp != 0) complain(address, "the write response is an error");
                response_left = false;
            }
            tick();
            if (address_taken) address_left = false, top->axi_awvalid = 0;
            if (data_taken) data_left = false, top->axi_wvalid = 0;
        }
        top->axi_bready = 0;
    }

    uint32_t read(uint32_t address) {
        gap();
        uint32_t found = 0;
        switch (window) {
        case 1:
            top->avs_address = address;
            top->avs_read = 1;
            for (bool waits = true; waits; tick()) {
                settle();
                waits = top->avs_waitrequest;
            }
            top->avs_read = 0;
            for (bool waits = true; waits; tick()) {
                settle();
                waits = !top->avs_readdatavalid;
                found = top->avs_readdata;
                if (!waits && top->avs_response != 0)
                    complain(address, "the read response is an error");
            }
            return found;
        case 2: return read_axi(address);
        default:
            top->bus_address = address;
            top->bus_read = 1;
            for (bool waits = true; waits; tick(), top->bus_read = 0) {
                settle();
                waits = !top->bus_readvalid;
                found = top->bus_readdata;
            }
            return found;
        }
    }

    uint32_t read_axi(uint32_t address) {
        bool address_left = true;
        top->axi_araddr = static_cast<uint64_t>(address) << 2;
        for (;;) {
            if (address_left && !top->axi_arvalid) top->axi_arvalid = goes();
            top->axi_rready = goes();
            settle();
            const bool address_taken = top->axi_arvalid && top->axi_arready;
            const bool data_taken = top->axi_rvalid && top->axi_rready;
            const uint32_t found = top->axi_rdata;
            if (data_taken && (address_left || top->axi_rresp != 0))
                complain(address, "the read response is an error");
            tick();
            if (address_taken) address_left = false, top->axi_arvalid = 0;
            if (data_taken) {
                top->axi_rready = 0;
                return found;
            }
        }
    }

    // ---- Commands.

    void read_back(const Command& command) {
        const uint32_t found = read(command.address);
        ++words_read;
        if (found != command.data && is_told()) {
            std::printf("address %x reads %08x instead of %08x:\n", command.address, found,
                        command.data);
            tell_line("reads.txt", command.note);
        }
    }

    void wait(const Command& command) {
        const uint64_t since = clocks;
        // On the bus the status is read in every clock, so that no state of it
        // is missed.
        const bool every_clock = window == 0;
        top->bus_address = command.address;
        top->bus_read = every_clock;
        for (uint32_t found = 0; (found & command.data) != command.data;) {
            bool seen = true;
            if (every_clock) {
                settle();
                seen = top->bus_readvalid;
                if (seen) found = top->bus_readdata;
                tick();
            } else {
                found = read(command.address);
            }
            if (seen && (found & 3) == 0)
                complain(command.address, "the status is neither running nor done");
            if (clocks - since > ROBOVEC_MOST_WAIT)
                give_up("run " + std::to_string(run_number) + " has not ended after "
                        + std::to_string(clocks - since) + " clocks");
        }
        // Reads on their way are of no interest.
        top->bus_read = 0;
        for (int clock = 0; clock < 8; ++clock) tick();
        if (next_cycle != ROBOVEC_CYCLES && is_told())
            std::printf("run %" PRIu64 " ended before cycle %u of %u\n", run_number, next_cycle,
                        ROBOVEC_CYCLES);
        if (place != ROBOVEC_OPERATIONS && is_told())
            std::printf("run %" PRIu64 ": %zu of %u results were not seen\n", run_number,
                        ROBOVEC_OPERATIONS - place, ROBOVEC_OPERATIONS);
        in_run = false;
    }

    bool report() {
        if (run_number + 1 != ROBOVEC_RUNS && is_told()) std::printf("not all runs were started\n");
        static const char* const names[] = {"host bus", "Avalon-MM", "AXI4-Lite"};
        std::printf("%s " ROBOVEC_NAME ", Verilator, %s: %" PRIu64 " runs of %u cycles, %" PRIu64
                    " results compared each in its cycle, %" PRIu64 " words read back, %" PRIu64
                    " clocks, %" PRIu64 " mistakes\n",
                    mistakes == 0 ? "PASS" : "FAIL", names[window], run_number + 1,
                    ROBOVEC_CYCLES, compared, words_read, clocks, mistakes);
        return mistakes == 0;
    }
};

} // namespace

int main(int count, char** arguments) {
    static const char* const names[] = {"bus", "avalon", "axi4lite"};
    const Expected expected;
    bool is_right = true, is_asked = false;
    for (int window = 0; window < 3; ++window) {
        bool asked = count == 1;
        for (int i = 1; i < count; ++i) asked = asked || std::strcmp(arguments[i], names[window]) == 0;
        if (!asked) continue;
        is_asked = true;
        if (!Bench(expected, window).run()) is_right = false;
        std::fflush(stdout);
    }
    if (!is_asked) give_up("the windows are: bus, avalon, axi4lite");
    return is_right ? 0 : 1;
}
