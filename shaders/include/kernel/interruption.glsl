// Tells whether the driver has ended the loops of an invocation early.
//
// Mesa's llvmpipe ends every loop of an invocation once its loops have taken 65,535 rounds in all, and
// reports nothing. The 8 or 16 invocations that run in one SIMD vector share these rounds. A kernel
// with long loops calls `interrupted` at its end.
//
// Kernels that follow paths are built in two variants. The plain variant counts the invocations that
// were ended early; if there are any, the host discards the dispatch and uses the resumable variant
// (IS_RESUMABLE; src/render/passes/path.rs). That variant calls `interrupted` after every segment:
// - A segment that was ended early does not count. The invocation stores the path as it was before the
//   segment and is UNFINISHED. Another dispatch (`resumed`) goes on, with 65,535 new rounds.
// - An invocation that has not finished a single segment is STUCK. It gets a workgroup to itself: of
//   `spread` invocations, only one works.
// - A path is cut if one of its segments needs too many rounds even then.
// So the result of a path depends neither on its neighbours nor on the size of dispatches.

// Whether further loops would be ended after their first round.
bool interrupted() {
    // 2, since every dispatch has one layer of workgroups. The compiler must not know that number: it
    // would leave out the loop.
    uint wanted = gl_NumWorkGroups.z + 1u;
    uint rounds = 0u;
    for (uint i = 0u; i < wanted; i++) {
        rounds++;
    }
    return rounds < wanted;
}

// What is next for an invocation that follows paths.
export const uint FINISHED = 0u;   // nothing
export const uint UNFINISHED = 1u; // another dispatch
export const uint STUCK = 2u;      // a dispatch in which it is alone in its workgroup
