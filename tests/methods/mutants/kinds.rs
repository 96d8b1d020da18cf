//! How a broken method is declared.

/// Mistakes of one kind are one type: every type is compiled for every kernel, and that takes minutes.
macro_rules! broken {
    ($kind:ident, $mistake:ident, $base:ident, $memory:ident, $inside:literal
        $($(#[doc = $doc:literal])+ $name:ident: $method:ident,
        |$field:ident, $x:ident, $v:ident, $step_state:ident| $body:block)*) => {
        #[derive(Clone, Copy)]
        enum $mistake {$($(#[doc = $doc])+ $name),*}

        impl $mistake {
            fn chosen() -> &'static std::thread::LocalKey<std::cell::Cell<Option<Self>>> {
                thread_local! {
                    static CHOSEN: std::cell::Cell<Option<$mistake>> = const { std::cell::Cell::new(None) };
                }
                &CHOSEN
            }
        }

        #[derive(Clone, Copy, Default)]
        struct $kind;

        impl Integrator for $kind {
            const METHOD: Method = Method::$base;
            const STATE: MethodStateKind = MethodStateKind::$memory;
            const DAMPS_INSIDE: bool = $inside;

            fn step<F: Field>(
                field: &mut F,
                x: F::Space,
                v: F::Space,
                step_state: &mut StepState<F>,
            ) -> (F::Space, F::Space) {
                match $mistake::chosen().get() {
                    $(Some($mistake::$name) => $name::step(field, x, v, step_state),)*
                    None => (x, v),
                }
            }
        }

        $(
            struct $name;

            impl $name {
                #[inline(never)]
                fn step<F: Field>(
                    $field: &mut F,
                    $x: F::Space,
                    $v: F::Space,
                    $step_state: &mut StepState<F>,
                ) -> (F::Space, F::Space) {
                    $body
                }

                fn mutant(name: &'static str, killer: Checked) -> (Stepper, Checked) {
                    let tick = |bare: &mut Bare| {
                        $mistake::chosen().set(Some($mistake::$name));
                        bare.tick_with::<$kind>();
                    };
                    (Stepper { name, method: Method::$method, tick }, killer)
                }
            }
        )*
    };
}
