//! Pipelines of the real passes: printed ones read back, and mistakes are
//! reported with their place.

use robovec_passes::registry::REGISTRY;

fn message(text: &str) -> String {
    REGISTRY.pipeline(text).expect_err("a mistake").to_string()
}

#[test]
fn printing_and_parsing_are_inverse() {
    for text in [
        "atomise",
        "atomise,cse,dce",
        "atomise,fixpoint{max=3}(cse,fixpoint{max=8}(dce,cse)),dce",
        "atomise,mixed{narrow=\"float(8,17)\"}",
        "atomise,meet{moves=\"balance,cse; lookahead{width=3},cse\" operations=9}",
    ] {
        let pipeline = REGISTRY.pipeline(text).expect("well formed");
        assert_eq!(pipeline.to_string(), text);
        assert_eq!(
            REGISTRY.pipeline(&pipeline.to_string()).expect("printed"),
            pipeline
        );
    }
    assert_eq!(
        REGISTRY
            .pipeline(" atomise , fixpoint ( cse , ) ")
            .map(|p| p.to_string())
            .ok(),
        None,
        "a comma before a closing parenthesis is a mistake"
    );
    assert_eq!(
        REGISTRY
            .pipeline("atomise,\n dce, // both\n")
            .expect("as in a file")
            .to_string(),
        "atomise,dce"
    );
}

#[test]
fn mistakes_are_named_and_placed() {
    assert!(message("atomize").contains("did you mean 'atomise'?"));
    assert!(message("atomise,,cse").contains("<-passes>:1:9"));
    assert!(message("cse{turbo}").contains("the pass 'cse' has no option 'turbo'"));
    assert!(message("fixpoint").contains("needs a group"));
    assert!(message("fixpoint{max=0}(cse)").contains("an integer from 1 to 1000 is"));
    assert!(message("fixpoint{max}(cse)").contains("needs a value"));
    assert!(message("").contains("empty"));
    assert!(message("cse;dce").contains("not allowed in a pipeline"));
    assert!(message("$fpgo").contains("did you mean '$fpga'?"));
}

#[test]
fn hostile_pipelines_are_refused_quickly() {
    let deep = format!("{}cse{}", "fixpoint(".repeat(50_000), ")".repeat(50_000));
    assert!(message(&deep).contains("at most 16 deep"));
    assert!(REGISTRY.pipeline(&"(".repeat(1 << 20)).is_err());
    assert!(REGISTRY.pipeline(&"cse,".repeat(1 << 19)).is_err());
}
