// Streams vectors through the verilated `top` and compares its results: each
// exactly as many enabled clocks after its operands as the operator has
// stages, and unchanged while enable is low.

#include "Vtop.h"
#include "verilated.h"
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

struct Vector {
    uint64_t operation, left, right, addend, result;
};

static std::vector<Vector> read(const char *name) {
    std::vector<Vector> vectors;
    FILE *file = std::fopen(name, "rb");
    if (!file) std::exit(2);
    std::fseek(file, 0, SEEK_END);
    vectors.resize(std::ftell(file) / sizeof(Vector));
    std::rewind(file);
    if (std::fread(vectors.data(), sizeof(Vector), vectors.size(), file) != vectors.size()) std::exit(2);
    std::fclose(file);
    return vectors;
}

int main(int, char **arguments) {
    const std::vector<Vector> vectors = read(arguments[1]);
    const size_t stages = std::strtoul(arguments[2], nullptr, 10);
    Vtop top;
    size_t issued = 0, checked = 0, wrong = 0;
    uint32_t random = 1;
    while (issued < vectors.size() + stages - 1) {
        random ^= random << 13;
        random ^= random >> 17;
        random ^= random << 5;
        const bool enable = random % 8 != 0;
        const size_t place = enable ? issued : random;
        const Vector &vector = vectors[place % vectors.size()];
        top.enable = enable;
        top.operation = vector.operation;
        top.left = vector.left;
        top.right = vector.right;
        top.addend = vector.addend;
        top.clock = 0;
        top.eval();
        top.clock = 1;
        top.eval();
        if (enable) {
            ++issued;
            if (issued >= stages) ++checked;
        }
        if (issued >= stages) {
            const Vector &done = vectors[issued - stages];
            if (top.result != done.result && wrong++ < 5)
                std::printf("vector %llx: %llx %llx %llx must give %llx, gives %llx\n",
                            (unsigned long long)done.operation, (unsigned long long)done.left,
                            (unsigned long long)done.right, (unsigned long long)done.addend,
                            (unsigned long long)done.result, (unsigned long long)top.result);
        }
    }
    std::printf("checked %zu wrong %zu\n", checked, wrong);
    return 0;
}
