// Mesa's llvmpipe ends every loop of an invocation once they have gone 65,535 rounds in all,
// and says nothing. A kernel with long loops asks at its end whether that has happened.

// Whether loops no longer go round. `two` is 2, but a compiler must not know it.
bool interrupted(uint two) {
    uint rounds = 0u;
    for (uint i = 0u; i < two; i++) {
        rounds++;
    }
    return rounds < two;
}
